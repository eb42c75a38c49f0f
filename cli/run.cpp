#include "musher/cli/run.hpp"

#include <cstdlib>
#include <exception>
#include <string>

#include "musher/cli/command_line.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/console/terminal_screen.hpp"

namespace musher::cli {
namespace {

// The transport, and the processes that `up` starts, read these from the environment.
void SetEnvironment(const GlobalOptions& global) {
  if (global.domain) setenv("ROS_DOMAIN_ID", std::to_string(*global.domain).c_str(), 1);
  if (global.transport) setenv("MUSHER_TRANSPORT", global.transport->c_str(), 1);
}

ExitCode EndOfParse(const ParseEnd& end, Console& console) {
  if (end.exit == ExitCode::kDone) {
    console.Print(end.out);
    return end.exit;
  }
  return console.Fail({end.exit, {kCodeParametersInvalid, end.err}});
}

}  // namespace

int Run(int argc, const char* const* argv, std::ostream& out, std::ostream& err, bool terminal) {
  const auto parsed = ParseCommandLine(argc, argv);
  if (const auto* end = std::get_if<ParseEnd>(&parsed)) {
    Console console(out, err, {end->json, false, terminal});
    return static_cast<int>(console.AfterOutput(EndOfParse(*end, console)));
  }
  const auto& line = std::get<CommandLine>(parsed);
  SetEnvironment(line.global);
  FitTables(terminal ? TerminalScreen::SizeNow().columns : 0);
  Console console(out, err,
                  {line.global.json, WantsColour(line.global.colour, terminal), terminal});
  try {
    return static_cast<int>(console.AfterOutput(line.run(line.global, console)));
  } catch (const std::exception& e) {  // a system resource is exhausted
    return static_cast<int>(console.Fail({kCodeFailed, e.what()}));
  }
}

}  // namespace musher::cli
