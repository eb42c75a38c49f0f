#include "musher/controller/cli/run.hpp"

#include <cstdlib>
#include <exception>
#include <string>

#include "musher/controller/cli/command_line.hpp"
#include "musher/controller/cli/commands.hpp"

namespace musher::cli {
namespace {

// The transport, and the processes that `up` starts, read these from the environment.
void SetEnvironment(const GlobalOptions& global) {
  if (global.domain) setenv("ROS_DOMAIN_ID", std::to_string(*global.domain).c_str(), 1);
  if (global.transport) setenv("MUSHER_TRANSPORT", global.transport->c_str(), 1);
}

struct Dispatch {
  const GlobalOptions& global;
  Console& console;

  ExitCode operator()(const CheckOptions& o) const { return Check(o, console); }
  ExitCode operator()(const UpOptions& o) const { return Up(o, global, console); }
  ExitCode operator()(const DownOptions& o) const { return Down(o, global, console); }
  ExitCode operator()(const StatusOptions& o) const { return Status(o, global, console); }
  ExitCode operator()(const SetOptions& o) const { return Set(o, global, console); }
  ExitCode operator()(const RestartOptions& o) const { return Restart(o, global, console); }
  ExitCode operator()(const EstopOptions& o) const { return Estop(o, global, console); }
  ExitCode operator()(const CapabilitiesOptions& o) const {
    return Capabilities(o, global, console);
  }
  ExitCode operator()(const WakeOptions&) const { return Wake(global, console); }
  ExitCode operator()(const KeepOptions& o) const { return Keep(o, global, console); }
  ExitCode operator()(const LowPowerOptions& o) const { return LowPower(o, global, console); }
  ExitCode operator()(const PowerOffOptions&) const { return PowerOff(global, console); }
  ExitCode operator()(const RebootOptions&) const { return Reboot(global, console); }
  ExitCode operator()(const PlanOptions& o) const { return Plan(o, global, console); }
  ExitCode operator()(const HistoryOptions& o) const { return History(o, global, console); }
  ExitCode operator()(const ReplayOptions& o) const { return Replay(o, console); }
  ExitCode operator()(const BehaviorOptions& o) const { return Behavior(o, global, console); }
  ExitCode operator()(const GraphOptions& o) const { return Graph(o, global, console); }
  ExitCode operator()(const SimulateOptions& o) const { return Simulate(o, console); }
  ExitCode operator()(const KeysInitOptions& o) const { return KeysInit(o, console); }
  ExitCode operator()(const KeysAddOptions& o) const { return KeysAdd(o, global, console); }
  ExitCode operator()(const KeysRevokeOptions& o) const { return KeysRevoke(o, global, console); }
  ExitCode operator()(const KeysListOptions&) const { return KeysList(global, console); }
  ExitCode operator()(const OtaKeygenOptions& o) const { return OtaKeygen(o, console); }
  ExitCode operator()(const OtaBundleOptions& o) const { return OtaBundle(o, console); }
  ExitCode operator()(const OtaInitOptions& o) const { return OtaInit(o, console); }
  ExitCode operator()(const OtaVerifyOptions& o) const { return OtaVerify(o, global, console); }
  ExitCode operator()(const OtaInstallOptions& o) const { return OtaInstall(o, global, console); }
  ExitCode operator()(const OtaStatusOptions& o) const { return OtaStatus(o, global, console); }
  ExitCode operator()(const OtaRollbackOptions& o) const { return OtaRollback(o, global, console); }
  ExitCode operator()(const CompletionOptions& o) const { return Completion(o, console); }
  ExitCode operator()(const CompleteOptions& o) const { return Complete(o, global, console); }
};

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
    return static_cast<int>(EndOfParse(*end, console));
  }
  const auto& line = std::get<CommandLine>(parsed);
  SetEnvironment(line.global);
  Console console(out, err,
                  {line.global.json, WantsColour(line.global.colour, terminal), terminal});
  try {
    return static_cast<int>(std::visit(Dispatch{line.global, console}, line.command));
  } catch (const std::exception& e) {  // a system resource is exhausted
    return static_cast<int>(console.Fail({kCodeFailed, e.what()}));
  }
}

}  // namespace musher::cli
