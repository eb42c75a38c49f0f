// musher view, musher record and musher play: programs of their own, see view/. `musher` does not
// link their libraries, so a robot without them has all other commands.

#include "musher/cli/commands/external.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "musher/base/program_path.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/grammar/grammar.hpp"

namespace musher::cli {
namespace {

struct ExternalOptions {
  std::vector<std::string> arguments;
};

// What was given before the command reaches the program by the environment.
void PassOn(const GlobalOptions& global) {
  const auto set = [](const char* name, const std::string& value) {
    if (!value.empty()) setenv(name, value.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
  };
  set("MUSHER_NAMESPACE", global.name_space);
  set("MUSHER_MACHINE", global.machine);
  set("MUSHER_KEYS", global.keys);
  if (!global.keys.empty()) set("MUSHER_IDENTITY", global.identity);
}

ExitCode Run(const std::string& program, std::vector<std::string> leading,
             const ExternalOptions& options, const GlobalOptions& global, Console& console) {
  PassOn(global);
  leading.insert(leading.end(), options.arguments.begin(), options.arguments.end());
  return console.Fail(RunExternal(program, leading));
}

ExitCode RunView(const ExternalOptions& options, const GlobalOptions& global, Console& console) {
  return Run("musher-view", {}, options, global, console);
}

ExitCode RunRecord(const ExternalOptions& options, const GlobalOptions& global, Console& console) {
  return Run("musher-record", {"record"}, options, global, console);
}

ExitCode RunPlay(const ExternalOptions& options, const GlobalOptions& global, Console& console) {
  return Run("musher-record", {"play"}, options, global, console);
}

using ExternalCommand = ExitCode (*)(const ExternalOptions&, const GlobalOptions&, Console&);

void AddProgram(Grammar& grammar, const std::string& name, const std::string& what,
                ExternalCommand run) {
  auto added =
      grammar.Add<ExternalOptions>(name, what, run, "");  // the program prints its own help
  CLI::App* app = &added.app;
  ExternalOptions* options = &added.options;
  app->set_help_flag();
  app->fallthrough(false);
  app->prefix_command();
  app->parse_complete_callback([app, options] { options->arguments = app->remaining(); });
}

}  // namespace

Result<std::string> FindExternal(const std::string& folder, const std::string& program) {
  const std::string found =
      FindInPath(program, folder.empty() ? SearchPath() : folder + ":" + SearchPath());
  if (!found.empty()) return found;
  return Error{kCodeParametersInvalid, "the program " + program + " is neither in " + folder +
                                           " nor in PATH; install the package musher-view"};
}

Error RunExternal(const std::string& program, const std::vector<std::string>& arguments) {
  const auto found = FindExternal(OwnProgram().parent_path().string(), program);
  if (!found) return found.error();
  std::vector<std::string> words = {found.value()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  execv(argv.front(), argv.data());
  const std::string why = std::strerror(errno);  // NOLINT(concurrency-mt-unsafe)
  return {kCodeFailed, found.value() + " cannot be executed: " + why};
}

void AddExternal(Grammar& grammar) {
  AddProgram(grammar, "view", "Show the robot in a browser, and to Foxglove", RunView);
  AddProgram(grammar, "record", "Record what happens into an MCAP file", RunRecord);
  AddProgram(grammar, "play", "Publish what was recorded", RunPlay);
}

}  // namespace musher::cli
