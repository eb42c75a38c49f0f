#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "musher/base/date_text.hpp"
#include "musher/base/joined.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/doctor/checks.hpp"
#include "musher/transport/security/key_folder.hpp"

namespace musher::cli {
namespace {

constexpr std::chrono::days kExpiresSoon(30);
constexpr unsigned int kGroupAndOthers = 077;  // permissions of the group and of others

DoctorCheck CheckKeyFiles(const DoctorFacts& facts) {
  DoctorCheck check{"keys"};
  if (!facts.config || facts.config->keys.empty())
    return NotApplicable(check,
                         facts.config ? "the config has no [security]" : "no config was given");
  const auto command = [&](const std::string& identity) {
    return fmt::format("musher keys add {} --force --keys {}", identity,
                       ShellWord(facts.config->keys));
  };
  check.health = CheckStatus::kError;
  if (!facts.keys_untrusted.empty()) {
    check.reason = facts.keys_untrusted;
    // What another user could have put there is not trusted afterwards, either.
    const std::string path = ShellWord(facts.config->keys);
    check.fix = facts.keys_of_another ? fmt::format("sudo chown -R -h \"$USER\" {} && ", path) : "";
    check.fix += fmt::format("chmod -R go-w {} && musher keys init {} --force", path,
                             ShellWord(facts.config->file));
    return check;
  }
  for (const KeyFacts& key : facts.keys) {
    if ((key.mode & kGroupAndOthers) != 0) {
      check.reason = fmt::format(
          "{} has the permissions {:o}: other users can read the private key", key.file, key.mode);
      check.fix = "chmod 600 " + ShellWord(key.file);
      return check;
    }
    if (!key.error.empty()) {
      check.reason = key.identity + ": " + key.error;
      check.fix = facts.keys_made
                      ? command(key.identity)
                      : fmt::format("musher keys init {}", ShellWord(facts.config->file));
      return check;
    }
  }
  check.health = CheckStatus::kOk;
  if (facts.keys.empty()) return check;
  const auto first =
      std::min_element(facts.keys.begin(), facts.keys.end(),
                       [](const auto& a, const auto& b) { return a.until < b.until; });
  check.reason =
      fmt::format("{}, the first expires on {} ({})", Counted(facts.keys.size(), "certificate"),
                  FormatUtc(first->until), first->identity);
  if (first->until < facts.now + kExpiresSoon) {
    check.health = CheckStatus::kWarning;
    check.reason += ": within 30 days; the process loses its connection then";
    check.fix = command(first->identity);
  }
  return check;
}

DoctorCheck CheckCommands(const DoctorFacts& facts) {
  DoctorCheck check{"programs"};
  if (!facts.config) return NotApplicable(check, "no config was given");
  if (facts.programs.empty()) {
    const auto started =
        std::count_if(facts.config->actuators.begin(), facts.config->actuators.end(),
                      [](const auto& a) { return !a.command.empty(); });
    check.reason = fmt::format("{} found and accepted", Counted(started, "command"));
    return check;
  }
  check.health = HasError(facts.programs) ? CheckStatus::kError : CheckStatus::kWarning;
  check.reason = FormatDiagnostic(facts.programs.front());
  if (facts.programs.size() > 1) {
    check.reason += fmt::format(" (and {} more)", facts.programs.size() - 1);
  }
  check.fix = "musher check " + ShellWord(facts.config->file);
  return check;
}

DoctorCheck CheckTimes(const DoctorFacts& facts) {
  DoctorCheck check{"time limits"};
  const TimesFacts& times = facts.times;
  if (!facts.config) return NotApplicable(check, "no config was given");
  if (!times.error.empty()) return NotApplicable(check, times.error);
  if (times.commands == 0)
    return NotApplicable(check, "no command and no start in the last 7 days");
  if (times.warnings.empty()) {
    check.reason = fmt::format("{} in the last 7 days, none overdue or close to its limit",
                               Counted(times.commands, "command or start", "commands and starts"));
    return check;
  }
  check.health = CheckStatus::kWarning;
  check.reason = times.warnings.front();
  if (times.warnings.size() > 1) {
    check.reason += fmt::format(" (and {} more)", times.warnings.size() - 1);
  }
  check.fix = "musher times " + ShellWord(facts.config->file) + " --since 7d";
  return check;
}

DoctorCheck CheckOtherMachines(const DoctorFacts& facts) {
  DoctorCheck check{"machine"};
  if (!facts.controllers_error.empty()) return NotApplicable(check, facts.controllers_error);
  if (facts.controllers.empty() && !facts.in_other_network.empty()) {
    check.health = CheckStatus::kWarning;
    check.reason = facts.in_other_network;
    check.fix = "run the command in that network namespace";
    return check;
  }
  if (facts.controllers.empty()) {
    check.reason =
        fmt::format("none runs in {} of domain {}", NamespaceText(facts.name_space), facts.domain);
    return check;
  }
  if (!facts.controllers.front().reachable) {
    check.health = CheckStatus::kWarning;
    if (const pid_t pid = facts.controllers.front().pid; facts.controllers.front().stopped) {
      check.reason = fmt::format("process {} leads a machine in {} of domain {}, and is stopped",
                                 pid, NamespaceText(facts.name_space), facts.domain);
      check.fix = fmt::format("kill -CONT {}", pid);
      return check;
    }
    check.reason = fmt::format(
        "process {} leads a machine in {} of domain {} on this host, but does not answer in this "
        "environment",
        facts.controllers.front().pid, NamespaceText(facts.name_space), facts.domain);
    check.fix = "use its CYCLONEDDS_URI, --transport and --keys";
    return check;
  }
  std::vector<std::string> running;
  for (const ControllerFacts& one : facts.controllers) {
    running.push_back(fmt::format("{} (pid {}{})", one.machine, one.pid,
                                  one.host.empty() ? "" : " on another host"));
  }
  check.reason = fmt::format("{} {} already in {} of domain {}", Joined(running),
                             running.size() == 1 ? "runs" : "run", NamespaceText(facts.name_space),
                             facts.domain);
  const bool other = facts.config && facts.controllers.front().machine != facts.config->name;
  if (!facts.config || (!other && facts.controllers.size() == 1)) return check;
  check.health = CheckStatus::kError;
  check.reason += other ? fmt::format(": {} cannot start there", facts.config->name)
                        : std::string(": only one of them can lead");
  check.fix =
      "musher down, or give this machine a namespace in [controller] or a ROS_DOMAIN_ID of "
      "its own";
  return check;
}

DoctorCheck CheckVersionOfController(const DoctorFacts& facts) {
  DoctorCheck check{"version"};
  check.reason = "musher " + facts.version;
  for (const ControllerFacts& one : facts.controllers) {
    if (one.version.empty() || one.version == facts.version) continue;
    check.health = CheckStatus::kWarning;
    check.reason = fmt::format("the controller (pid {}) is musher {}, this program is {}", one.pid,
                               one.version, facts.version);
    check.fix = one.config_file.empty()
                    ? "musher up --takeover with its config"
                    : "musher up --detach --takeover " + ShellWord(one.config_file);
  }
  return check;
}

}  // namespace

std::vector<DoctorCheck> CheckMachine(const DoctorFacts& facts) {
  return {CheckKeyFiles(facts), CheckCommands(facts), CheckTimes(facts), CheckOtherMachines(facts),
          CheckVersionOfController(facts)};
}

std::vector<DoctorCheck> Diagnose(const DoctorFacts& facts) {
  std::vector<DoctorCheck> all;
  for (auto checks : {CheckNetwork(facts), CheckHost(facts), CheckStorage(facts),
                      CheckMachine(facts), CheckHosts(facts)}) {
    all.insert(all.end(), checks.begin(), checks.end());
  }
  return all;
}

CheckStatus Worst(const std::vector<DoctorCheck>& checks) {
  CheckStatus worst = CheckStatus::kNotApplicable;
  for (const DoctorCheck& check : checks) worst = std::max(worst, check.health);
  return worst;
}

}  // namespace musher::cli
