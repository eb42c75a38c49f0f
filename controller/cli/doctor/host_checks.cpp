#include <fmt/chrono.h>
#include <fmt/format.h>

#include "musher/controller/cli/doctor/checks.hpp"

namespace musher::cli {
namespace {

using enum CheckStatus;

// A process needs some 30 descriptors, and the controller 4 more for each actuator.
constexpr std::uint64_t kFilesOfAProcess = 256;
constexpr std::uint64_t kFilesOfAnActuator = 8;
// Below this the journal and the logs of a usual config may not find room.
constexpr std::int64_t kLittleDisk = 200ll << 20;
constexpr std::int64_t kFewInodes = 1000;
// Musher did not exist before; a computer without a battery for its clock starts in 1970 or so.
constexpr std::int64_t kFirstPossibleTime = 1'735'689'600;  // 2025-01-01
constexpr std::int64_t kJumpSeconds = 5;

double Mib(std::int64_t bytes) {
  return static_cast<double>(bytes) / (1 << 20);
}

std::string WallText(std::int64_t seconds) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

DoctorCheck CheckClock(const DoctorFacts& facts) {
  DoctorCheck check{"clock"};
  const ClockFacts& clock = facts.clock;
  if (clock.wall_s < kFirstPossibleTime) {
    check.health = kError;
    check.reason = "the wall clock shows " + WallText(clock.wall_s) +
                   ": certificates are not valid yet, and logs have wrong times";
    check.fix = "sudo timedatectl set-ntp true";
    return check;
  }
  if (clock.newest_file_s > clock.wall_s + kJumpSeconds) {
    check.health = kWarning;
    check.reason =
        fmt::format("the wall clock was set back: the state folder has a file of {}, {} s from now",
                    WallText(clock.newest_file_s), clock.newest_file_s - clock.wall_s);
    check.fix = "timedatectl timesync-status";
    return check;
  }
  const bool several_hosts = facts.profile == TransportProfile::kLan || !facts.keys.empty();
  if (!clock.error.empty()) {
    check.health = kNotApplicable;
    check.reason = clock.error;
    return check;
  }
  check.reason =
      fmt::format("{} (error at most {} ms, clock source {})",
                  clock.synchronised ? "synchronised" : "not synchronised",
                  ToMilliseconds(clock.max_error), clock.source.empty() ? "unknown" : clock.source);
  if (clock.synchronised) return check;
  // Musher's own decisions use the steady clock.
  check.reason += several_hosts ? ": records of several hosts cannot be compared"
                                : "; that concerns only the times in logs and the journal";
  check.health = several_hosts ? kWarning : kOk;
  if (several_hosts) check.fix = "sudo timedatectl set-ntp true";
  return check;
}

DoctorCheck CheckClockSource(const DoctorFacts& facts) {
  DoctorCheck check{"steady clock"};
  const std::string& source = facts.clock.source;
  check.reason = "clock source " + source;
  if (source.empty()) {
    check.health = kNotApplicable;
    check.reason = "its source is not readable here";
  } else if (source == "jiffies" || source == "refined-jiffies") {
    check.health = kWarning;
    check.reason += ": it advances by whole ticks, so short times are inexact";
    check.fix = "cat /sys/devices/system/clocksource/clocksource0/available_clocksource";
  }
  return check;
}

DoctorCheck CheckStateFolder(const DoctorFacts& facts) {
  DoctorCheck check{"state folder"};
  if (!facts.state_dir) {
    check.health = kNotApplicable;
    check.reason = "no config was given";
    return check;
  }
  const FolderFacts& folder = *facts.state_dir;
  const bool exists = folder.path == folder.existing;
  check.health = kError;
  if (!folder.error.empty()) {
    check.reason = folder.path + ": " + folder.error;
    check.fix = "set state_dir in [controller] to a folder of a local disk";
  } else if (!folder.is_folder) {
    check.reason = folder.existing + " is not a folder";
    check.fix = "set another state_dir in [controller]";
  } else if (!folder.writable) {
    check.reason = folder.existing + " is not writable for this user" +
                   (exists ? "" : ", and " + folder.path + " does not exist");
    check.fix = fmt::format("sudo install -d -o \"$USER\" -m 700 '{}'", folder.path);
  } else {
    check.health = kOk;
    check.reason = folder.path + (exists ? " is writable" : " can be created");
  }
  return check;
}

DoctorCheck CheckDisk(const DoctorFacts& facts) {
  DoctorCheck check{"disk"};
  if (!facts.state_dir || !facts.state_dir->error.empty()) {
    check.health = kNotApplicable;
    check.reason = "no state folder to check";
    return check;
  }
  const FolderFacts& folder = *facts.state_dir;
  const std::int64_t needed =
      facts.config ? facts.config->journal_size_bytes + facts.config->logs_size_bytes : 0;
  check.reason =
      fmt::format("{:.0f} of {:.0f} MiB free", Mib(folder.free_bytes), Mib(folder.total_bytes));
  if (folder.free_bytes < kLittleDisk) {
    check.health = folder.free_bytes < kLittleDisk / 20 ? kError : kWarning;
    check.reason += " for the journal and the logs";
  } else if (folder.free_inodes >= 0 && folder.free_inodes < kFewInodes) {
    check.health = kWarning;
    check.reason += fmt::format(", but only {} more files", folder.free_inodes);
  } else if (folder.free_bytes < needed) {
    check.health = kWarning;
    check.reason +=
        fmt::format(", and journal_size_mb and logs_size_mb permit {:.0f}", Mib(needed));
    check.fix = "lower logs_size_mb in [controller], or free space: du -xh '" + folder.existing +
                "' | sort -h | tail";
    return check;
  }
  if (check.health != kOk) check.fix = "du -xh '" + folder.existing + "' | sort -h | tail";
  if (folder.in_memory && check.health != kError) {
    check.health = kWarning;
    check.reason +=
        "; it is in memory (tmpfs): a reboot deletes the journal, and an emergency stop "
        "is not remembered";
    if (check.fix.empty()) check.fix = "set state_dir in [controller] to a folder of a disk";
  }
  return check;
}

DoctorCheck CheckOpenFiles(const DoctorFacts& facts) {
  DoctorCheck check{"open files"};
  const std::size_t actuators = facts.config ? facts.config->actuators.size() : 0;
  const std::uint64_t needed = kFilesOfAProcess + kFilesOfAnActuator * actuators;
  check.reason = fmt::format("{} permitted, {} needed", facts.limits.files, needed);
  if (facts.limits.files >= needed) return check;
  check.health = kError;
  check.fix = facts.limits.files_hard >= needed
                  ? fmt::format("ulimit -n {}", needed)
                  : fmt::format(
                        "echo \"$USER hard nofile {0}\" | sudo tee "
                        "/etc/security/limits.d/musher.conf, log in again, ulimit -n {0}",
                        needed);
  return check;
}

DoctorCheck CheckBacktraces(const DoctorFacts& facts) {
  DoctorCheck check{"backtraces"};
  const Limits& limits = facts.limits;
  if (limits.tracer.empty()) {
    check.health = kWarning;
    check.reason = "neither eu-stack nor gdb is installed: a hung process is restarted without one";
    check.fix = "sudo apt-get install elfutils";
    return check;
  }
  check.reason = "by " + limits.tracer;
  const int scope = limits.ptrace_scope.value_or(0);
  if (scope == 0 || limits.may_trace) return check;
  check.health = kWarning;
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
    check.health = kWarning;
    check.reason += ": heartbeats may be late";
    check.fix = "raise CPUQuota= of the systemd unit, or --cpus of the container";
  }
  return check;
}

}  // namespace

std::vector<DoctorCheck> CheckHost(const DoctorFacts& facts) {
  return {CheckClock(facts),     CheckClockSource(facts), CheckStateFolder(facts), CheckDisk(facts),
          CheckOpenFiles(facts), CheckBacktraces(facts),  CheckCpu(facts)};
}

}  // namespace musher::cli
