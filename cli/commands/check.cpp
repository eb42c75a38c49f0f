// musher check FILE...: reports every error in state configs. Uses no network but with --hosts.

#include <CLI/CLI.hpp>
#include <filesystem>

#include "musher/cli/commands/commands.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/cli/config/group_check.hpp"
#include "musher/cli/config/key_check.hpp"
#include "musher/cli/config/limit_check.hpp"
#include "musher/cli/config/program_check.hpp"
#include "musher/cli/config/ros_check.hpp"
#include "musher/cli/console/error_json.hpp"
#include "musher/cli/doctor/host_facts.hpp"
#include "musher/cli/doctor/host_reach.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/ota/root.hpp"

namespace musher::cli {
namespace {

struct CheckOptions {
  std::vector<std::string> files;
  bool hosts = false;
};

// The config is in an upgrade root, or offers the manager's OTA service. A robot without upgrades
// gets no warning.
bool IsUpgradable(const MachineConfig& config) {
  if (config.policy && config.policy->manager) return true;
  std::error_code error;
  std::filesystem::path folder = std::filesystem::absolute(config.file, error).lexically_normal();
  while (folder.has_relative_path()) {
    folder = folder.parent_path();
    if (std::filesystem::exists(folder / ota::kRootFile, error)) return true;
  }
  return false;
}

void AddUpgradeFault(const MachineConfig& config, std::vector<Diagnostic>& diagnostics) {
  if (config.states.empty() || config.HasState(kOta) || !IsUpgradable(config)) return;
  diagnostics.push_back({config.file, 0, 0, Severity::kWarning,
                         "the machine has no state OTA, which upgrades need: `musher ota` "
                         "refuses this config; add OTA to `states` of [controller]"});
}

ExitCode Check(const CheckOptions& options, const GlobalOptions& /*global*/, Console& console) {
  std::vector<Diagnostic> all;
  for (const std::string& file : options.files) {
    ConfigReading reading = ReadConfigFile(file);
    if (const auto& read = reading.config ? reading.config : reading.faulty) {
      AddUpgradeFault(*read, reading.diagnostics);
      const auto found = CheckPrograms(*read);
      reading.diagnostics.insert(reading.diagnostics.end(), found.begin(), found.end());
      const auto keys = CheckKeys(*read);
      reading.diagnostics.insert(reading.diagnostics.end(), keys.begin(), keys.end());
      const auto ros = CheckRos(*read, transport::OwnEnvironment());
      reading.diagnostics.insert(reading.diagnostics.end(), ros.begin(), ros.end());
      const auto group = CheckLogGroup(*read);
      reading.diagnostics.insert(reading.diagnostics.end(), group.begin(), group.end());
      const Limits user = ReadLimits();
      const auto limits =
          CheckLimits(*read, {user.may_real_time, user.real_time, user.lowest_nice});
      reading.diagnostics.insert(reading.diagnostics.end(), limits.begin(), limits.end());
      const auto units = CheckOtherHosts(*read, ReadOwnHost(*read));
      reading.diagnostics.insert(reading.diagnostics.end(), units.begin(), units.end());
      const auto hosts =
          options.hosts ? CheckOtherHosts(*read, ReadOtherHosts(*read)) : std::vector<Diagnostic>();
      reading.diagnostics.insert(reading.diagnostics.end(), hosts.begin(), hosts.end());
      const auto rules = reading.config ? RulesOf(*read).diagnostics : std::vector<Diagnostic>();
      reading.diagnostics.insert(reading.diagnostics.end(), rules.begin(), rules.end());
      if (HasError(found) || HasError(group) || HasError(limits) || HasError(units) ||
          HasError(hosts) || HasError(rules)) {
        reading.config.reset();
      }
    }
    all.insert(all.end(), reading.diagnostics.begin(), reading.diagnostics.end());
    if (console.mode().json) continue;
    std::string text;
    for (const Diagnostic& d : reading.diagnostics) text += Printable(FormatDiagnostic(d)) + '\n';
    const std::string of_file = options.files.size() > 1 ? Printable(file) + ": " : "";
    if (reading.config) text += of_file + "ok: " + ConfigSummary(*reading.config) + '\n';
    console.Print(text);
  }
  if (console.mode().json) console.Print(CheckJson(all));
  return HasError(all) ? ExitCode::kUsage : ExitCode::kDone;
}

}  // namespace

void AddCheck(Grammar& grammar) {
  auto [app, options] = grammar.Add("check", "Report every error in a state config", Check,
                                    "musher check robot.toml");
  grammar.Offer(app.add_option("FILE", options.files, "State configs (TOML)"), Names::kConfigs)
      ->required()
      ->type_name("");
  app.add_flag("--hosts", options.hosts,
               "Also look at the other hosts of each machine, by ssh; 8 s\nat most");
}

}  // namespace musher::cli
