#pragma once
// The commands of `musher`, one file each: <command>.cpp. Each prints its result to the console and
// returns the exit code.

#include "musher/controller/cli/console.hpp"
#include "musher/controller/cli/exit_code.hpp"
#include "musher/controller/cli/options.hpp"

namespace musher::cli {

ExitCode Check(const CheckOptions& options, Console& console);
ExitCode Up(const UpOptions& options, const GlobalOptions& global, Console& console);
ExitCode Down(const DownOptions& options, const GlobalOptions& global, Console& console);
ExitCode Status(const StatusOptions& options, const GlobalOptions& global, Console& console);
ExitCode Set(const SetOptions& options, const GlobalOptions& global, Console& console);
ExitCode Restart(const RestartOptions& options, const GlobalOptions& global, Console& console);
ExitCode Estop(const EstopOptions& options, const GlobalOptions& global, Console& console);
ExitCode Capabilities(const CapabilitiesOptions& options, const GlobalOptions& global,
                      Console& console);
ExitCode Wake(const GlobalOptions& global, Console& console);
ExitCode Keep(const KeepOptions& options, const GlobalOptions& global, Console& console);
ExitCode LowPower(const LowPowerOptions& options, const GlobalOptions& global, Console& console);
ExitCode PowerOff(const GlobalOptions& global, Console& console);
ExitCode Reboot(const GlobalOptions& global, Console& console);
ExitCode Plan(const PlanOptions& options, const GlobalOptions& global, Console& console);
ExitCode History(const HistoryOptions& options, const GlobalOptions& global, Console& console);
ExitCode Replay(const ReplayOptions& options, Console& console);
ExitCode Behavior(const BehaviorOptions& options, const GlobalOptions& global, Console& console);
ExitCode Graph(const GraphOptions& options, const GlobalOptions& global, Console& console);
ExitCode Simulate(const SimulateOptions& options, Console& console);
ExitCode KeysInit(const KeysInitOptions& options, Console& console);
ExitCode KeysAdd(const KeysAddOptions& options, const GlobalOptions& global, Console& console);
ExitCode KeysRevoke(const KeysRevokeOptions& options, const GlobalOptions& global,
                    Console& console);
ExitCode KeysList(const GlobalOptions& global, Console& console);
ExitCode OtaKeygen(const OtaKeygenOptions& options, Console& console);
ExitCode OtaBundle(const OtaBundleOptions& options, Console& console);
ExitCode OtaInit(const OtaInitOptions& options, Console& console);
ExitCode OtaVerify(const OtaVerifyOptions& options, const GlobalOptions& global, Console& console);
ExitCode OtaInstall(const OtaInstallOptions& options, const GlobalOptions& global,
                    Console& console);
ExitCode OtaStatus(const OtaStatusOptions& options, const GlobalOptions& global, Console& console);
ExitCode OtaRollback(const OtaRollbackOptions& options, const GlobalOptions& global,
                     Console& console);
ExitCode Completion(const CompletionOptions& options, Console& console);
ExitCode Complete(const CompleteOptions& options, const GlobalOptions& global, Console& console);

}  // namespace musher::cli
