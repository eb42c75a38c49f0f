#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <limits>

#include "musher/base/date_text.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/doctor/checks.hpp"

namespace musher::cli {
namespace {

// A process needs some 30 descriptors, and the controller 4 more for each actuator.
constexpr std::uint64_t kFilesOfAProcess = 256;
constexpr std::uint64_t kFilesOfAnActuator = 8;
// Musher did not exist before; a computer without a battery for its clock starts in 1970 or so.
constexpr std::int64_t kFirstPossibleTime = 1'735'689'600;  // 2025-01-01
constexpr std::int64_t kJumpSeconds = 5;

std::string WallText(std::int64_t seconds) {
  return FormatUtc(std::chrono::sys_seconds(std::chrono::seconds(seconds)),
                   "%Y-%m-%d %H:%M:%S UTC");
}

DoctorCheck CheckClock(const DoctorFacts& facts) {
  DoctorCheck check{"clock"};
  const ClockFacts& clock = facts.clock;
  if (clock.wall_s < kFirstPossibleTime) {
    check.health = CheckStatus::kError;
    check.reason = "the wall clock shows " + WallText(clock.wall_s) +
                   ": certificates are not valid yet, and logs have wrong times";
    check.fix = "sudo timedatectl set-ntp true";
    return check;
  }
  if (clock.newest_file_s > clock.wall_s + kJumpSeconds) {
    check.health = CheckStatus::kWarning;
    check.reason =
        fmt::format("the wall clock was set back: the state folder has a file of {}, {} s from now",
                    WallText(clock.newest_file_s), clock.newest_file_s - clock.wall_s);
    check.fix = "timedatectl timesync-status";
    return check;
  }
  const bool several_hosts = facts.profile == TransportProfile::kLan || !facts.keys.empty();
  if (!clock.error.empty()) return NotApplicable(check, clock.error);
  check.reason =
      fmt::format("{} (error at most {} ms, clock source {})",
                  clock.synchronised ? "synchronised" : "not synchronised",
                  ToMilliseconds(clock.max_error), clock.source.empty() ? "unknown" : clock.source);
  if (clock.synchronised) return check;
  // Musher's own decisions use the steady clock.
  check.reason += several_hosts ? ": records of several hosts cannot be compared"
                                : "; that concerns only the times in logs and the journal";
  check.health = several_hosts ? CheckStatus::kWarning : CheckStatus::kOk;
  if (several_hosts) check.fix = "sudo timedatectl set-ntp true";
  return check;
}

DoctorCheck CheckClockSource(const DoctorFacts& facts) {
  DoctorCheck check{"steady clock"};
  const std::string& source = facts.clock.source;
  check.reason = "clock source " + source;
  if (source.empty()) {
    check.health = CheckStatus::kNotApplicable;
    check.reason = "its source is not readable here";
  } else if (source == "jiffies" || source == "refined-jiffies") {
    check.health = CheckStatus::kWarning;
    check.reason += ": it advances by whole ticks, so short times are inexact";
    check.fix = "cat /sys/devices/system/clocksource/clocksource0/available_clocksource";
  }
  return check;
}

DoctorCheck CheckOpenFiles(const DoctorFacts& facts) {
  DoctorCheck check{"open files"};
  const std::size_t actuators = facts.config ? facts.config->actuators.size() : 0;
  const std::uint64_t needed = kFilesOfAProcess + kFilesOfAnActuator * actuators;
  check.reason = fmt::format("{} permitted, {} needed", facts.limits.files, needed);
  if (facts.limits.files >= needed) return check;
  check.health = CheckStatus::kError;
  check.fix = facts.limits.files_hard >= needed
                  ? fmt::format("ulimit -n {}", needed)
                  : fmt::format(
                        "echo \"$USER hard nofile {0}\" | sudo tee "
                        "/etc/security/limits.d/musher.conf, log in again, ulimit -n {0}",
                        needed);
  return check;
}

// The priority with which `chrt` runs a program; 0: none that needs a permission.
std::uint64_t RealTimePriority(const std::vector<std::string>& command) {
  if (command.empty() || !(command[0] == "chrt" || command[0].ends_with("/chrt"))) return 0;
  for (std::size_t i = 1; i < command.size(); ++i) {
    const std::string& word = command[i];
    for (const char* other : {"-o", "--other", "-b", "--batch", "-i", "--idle", "-d"}) {
      if (word == other) return 0;
    }
    if (!word.starts_with('-')) return std::strtoull(word.c_str(), nullptr, 10);
  }
  return 0;
}

DoctorCheck CheckRealTime(const DoctorFacts& facts) {
  DoctorCheck check{"real-time priority"};
  constexpr std::uint64_t kHighest = 99;
  const std::uint64_t permitted = facts.limits.may_real_time ? kHighest : facts.limits.real_time;
  check.reason = permitted == 0 ? "none permitted" : fmt::format("up to {} permitted", permitted);
  std::uint64_t needed = 0;
  std::string name;
  const auto actuators = facts.config ? facts.config->actuators : PerActuator<ActuatorConfig>();
  for (const ActuatorConfig& actuator : actuators) {
    const std::uint64_t priority = RealTimePriority(actuator.command);
    if (priority > needed) name = actuator.name;
    needed = std::max(needed, priority);
  }
  check.reason += needed == 0 ? facts.config ? ", none requested by a command (chrt)" : ""
                              : fmt::format(", {} requests {} (chrt)", name, needed);
  if (needed <= permitted) return check;
  check.health = CheckStatus::kError;
  check.reason += ": its process cannot start";
  check.fix = fmt::format(
      "echo \"$USER - rtprio {0}\" | sudo tee /etc/security/limits.d/musher-rtprio.conf and log in "
      "again; for a systemd unit LimitRTPRIO={0}",
      needed);
  return check;
}

DoctorCheck CheckCoreDumps(const DoctorFacts& facts) {
  DoctorCheck check{"core dumps"};
  const CoreFacts& core = facts.core;
  if (core.pattern.empty()) return NotApplicable(check, "kernel.core_pattern is not readable here");
  const bool piped = core.pattern.starts_with('|');
  const std::string where =
      piped ? "to the program " + core.pattern.substr(1, core.pattern.find(' ') - 1)
      : core.pattern.starts_with('/')
          ? "to " + core.pattern
          : "to the working directory of the process, as " + core.pattern;
  if (core.limit == 0) {
    check.health = CheckStatus::kWarning;
    check.reason =
        "a process that crashes leaves none: the limit is 0 bytes; they would go " + where;
    check.fix = core.limit_hard > 0 ? "ulimit -c unlimited; for a systemd unit LimitCORE=infinity"
                                    : "echo \"$USER - core unlimited\" | sudo tee "
                                      "/etc/security/limits.d/musher-core.conf and log in again";
    return check;
  }
  const bool unlimited = core.limit == std::numeric_limits<std::uint64_t>::max();
  check.reason = where + (unlimited ? "" : fmt::format(", at most {} bytes", core.limit));
  if (core.obstacle.empty()) return check;
  check.health = CheckStatus::kWarning;
  check.reason += ": " + core.obstacle;
  check.fix = piped ? "sudo sysctl -w kernel.core_pattern=core.%e.%p"
                    : "sudo install -d -m 1777 " +
                          ShellWord(core.pattern.substr(0, core.pattern.rfind('/')));
  return check;
}

DoctorCheck CheckBacktraces(const DoctorFacts& facts) {
  DoctorCheck check{"backtraces"};
  const Limits& limits = facts.limits;
  if (limits.tracer.empty()) {
    check.health = CheckStatus::kWarning;
    check.reason =
        "neither eu-stack nor gdb is installed: a hung process is restarted without a backtrace";
    check.fix = "sudo apt-get install elfutils";
    return check;
  }
  check.reason = "by " + limits.tracer;
  const int scope = limits.ptrace_scope.value_or(0);
  if (scope == 0 || limits.may_trace) return check;
  check.health = CheckStatus::kWarning;
  check.reason += fmt::format(
      ", but kernel.yama.ptrace_scope is {}: this user may not trace the processes of the machine",
      scope);
  check.fix = scope == 3 ? "reboot with kernel.yama.ptrace_scope = 0"
                         : "sudo sysctl -w kernel.yama.ptrace_scope=0";
  return check;
}

DoctorCheck CheckCpu(const DoctorFacts& facts) {
  DoctorCheck check{"CPU"};
  const CpuFacts& cpu = facts.cpu;
  check.reason = fmt::format("{} usable", cpu.cpus);
  if (!cpu.quota) return check;
  check.reason += fmt::format(", limited to {:g} by the cgroup, throttled for {:.1f} s so far",
                              *cpu.quota, ToSeconds(cpu.throttled));
  if (*cpu.quota < 1 || cpu.throttled > Duration{}) {
    check.health = CheckStatus::kWarning;
    check.reason += ": heartbeats may be late";
    check.fix = "raise CPUQuota= of the systemd unit, or --cpus of the container";
  }
  return check;
}

}  // namespace

std::vector<DoctorCheck> CheckHost(const DoctorFacts& facts) {
  return {CheckClock(facts), CheckClockSource(facts), CheckOpenFiles(facts), CheckRealTime(facts),
          CheckCpu(facts),   CheckBacktraces(facts),  CheckCoreDumps(facts)};
}

}  // namespace musher::cli
