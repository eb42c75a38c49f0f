#include <fmt/format.h>

#include <algorithm>

#include "musher/base/words.hpp"
#include "musher/cli/doctor/checks.hpp"

namespace musher::cli {
namespace {

// Below this the journal and the logs of a usual config may not find room.
constexpr std::int64_t kLittleDisk = 200ll << 20;
constexpr std::int64_t kFewInodes = 1000;

double Mib(std::int64_t bytes) {
  return static_cast<double>(bytes) / (1 << 20);
}

DoctorCheck CheckStateFolder(const DoctorFacts& facts) {
  DoctorCheck check{"state folder"};
  if (!facts.state_dir) return NotApplicable(check, "no config was given");
  const FolderFacts& folder = *facts.state_dir;
  const bool exists = folder.path == folder.existing;
  check.health = CheckStatus::kError;
  if (!folder.error.empty()) {
    check.reason = folder.path + ": " + folder.error;
    check.fix = "set state_dir in [controller] to a folder of a local disk";
  } else if (!folder.is_folder) {
    check.reason = folder.existing + " is not a folder";
    check.fix = "set another state_dir in [controller]";
  } else if (!folder.writable) {
    check.reason = folder.existing + " is not writable for this user" +
                   (exists ? "" : ", and " + folder.path + " does not exist");
    check.fix = fmt::format("sudo install -d -o \"$USER\" -m 700 {}", ShellWord(folder.path));
  } else if (!folder.untrusted.empty()) {
    check.reason = folder.untrusted;
    check.fix =
        fmt::format("sudo chown -R -h \"$USER\" {0} && chmod -R go-w {0}", ShellWord(folder.path));
  } else if (!folder.write_error.empty()) {
    check.reason = fmt::format("writing to {} fails, {} KiB free: {}", folder.existing,
                               folder.free_bytes >> 10, folder.write_error);
    check.fix = "du -xh " + ShellWord(folder.existing) + " | sort -h | tail";
  } else {
    check.health = CheckStatus::kOk;
    check.reason = folder.path + (exists ? " is writable" : " can be created") +
                   fmt::format(", {:.0f} MiB free", Mib(folder.free_bytes));
  }
  return check;
}

DoctorCheck CheckDisk(const DoctorFacts& facts) {
  DoctorCheck check{"disk"};
  if (!facts.state_dir || !facts.state_dir->error.empty())
    return NotApplicable(check, "no state folder to check");
  const FolderFacts& folder = *facts.state_dir;
  const std::int64_t needed =
      facts.config ? facts.config->journal_size_bytes + facts.config->logs_size_bytes : 0;
  check.reason =
      fmt::format("{:.0f} of {:.0f} MiB free", Mib(folder.free_bytes), Mib(folder.total_bytes));
  if (folder.free_bytes < kLittleDisk) {
    check.health =
        folder.free_bytes < kLittleDisk / 20 ? CheckStatus::kError : CheckStatus::kWarning;
    check.reason += " for the journal and the logs";
  } else if (folder.free_inodes >= 0 && folder.free_inodes < kFewInodes) {
    check.health = CheckStatus::kWarning;
    check.reason += fmt::format(", but only {} more files", folder.free_inodes);
  } else if (folder.free_bytes < needed) {
    check.health = CheckStatus::kWarning;
    check.reason +=
        fmt::format(", and journal_size_mb and logs_size_mb permit {:.0f}", Mib(needed));
    check.fix = "lower logs_size_mb in [controller], or free space: du -xh " +
                ShellWord(folder.existing) + " | sort -h | tail";
    return check;
  }
  if (check.health != CheckStatus::kOk)
    check.fix = "du -xh " + ShellWord(folder.existing) + " | sort -h | tail";
  if (folder.in_memory && check.health != CheckStatus::kError) {
    check.health = CheckStatus::kWarning;
    check.reason +=
        "; it is in memory (tmpfs): a reboot deletes the journal, and an emergency stop "
        "is not remembered";
    if (check.fix.empty()) check.fix = "set state_dir in [controller] to a folder of a disk";
  }
  return check;
}

DoctorCheck CheckLock(const DoctorFacts& facts) {
  DoctorCheck check{"lock file"};
  if (!facts.lock) return NotApplicable(check, "no state folder to check");
  const LockFacts& lock = *facts.lock;
  const std::string folder = lock.path.substr(0, lock.path.rfind('/'));
  if (!lock.belongs_to.empty()) {
    check.health = CheckStatus::kError;
    check.reason = folder + " belongs to another machine, " + lock.belongs_to;
    check.fix = "give this machine a name or a state_dir of its own in [controller]";
  } else if (!lock.writable) {
    check.health = CheckStatus::kError;
    check.reason = lock.path + " belongs to " + lock.owner + ": this user cannot start the machine";
    check.fix = "sudo chown -R \"$USER\" " + ShellWord(folder);
  } else if (lock.held_by != 0) {
    check.reason = fmt::format("held by the controller (pid {})", lock.held_by);
  } else {
    check.reason = lock.path + (lock.owner.empty() ? " does not exist yet" : " is free");
  }
  return check;
}

// The disk of the state folder has a check of its own.
DoctorCheck CheckLogs(const DoctorFacts& facts) {
  DoctorCheck check{"log folder"};
  if (facts.log_dirs.empty()) return NotApplicable(check, "no state folder to check");
  for (const FolderFacts& folder : facts.log_dirs) {
    check.reason += (check.reason.empty() ? "" : "; ") + folder.path;
    const bool other_disk = !facts.state_dir || folder.device != facts.state_dir->device;
    const bool full = other_disk && folder.free_bytes < kLittleDisk;
    if (!folder.error.empty()) {
      check.health = CheckStatus::kError;
      check.reason += ": " + folder.error;
      check.fix = "set log in [controller] to a file of a local disk";
    } else if (!folder.is_folder) {
      check.health = CheckStatus::kError;
      check.reason += ": " + folder.existing + " is not a folder";
      check.fix = "mv " + ShellWord(folder.existing) + " " + ShellWord(folder.existing + ".old");
    } else if (!folder.writable) {
      check.health = CheckStatus::kError;
      check.reason += ": " + folder.existing + " is not writable for this user";
      check.fix = fmt::format("sudo chown \"$USER\" {}", ShellWord(folder.existing));
    } else if (full) {
      check.health =
          folder.free_bytes < kLittleDisk / 20 ? CheckStatus::kError : CheckStatus::kWarning;
      check.reason += fmt::format(": {:.0f} of {:.0f} MiB free", Mib(folder.free_bytes),
                                  Mib(folder.total_bytes));
      check.fix = "du -xh " + ShellWord(folder.existing) + " | sort -h | tail";
    }
    if (check.health != CheckStatus::kOk) return check;
    check.reason += folder.path == folder.existing ? " is writable" : " can be created";
  }
  if (facts.unwritable_logs.empty()) return check;
  const LogFacts& first = facts.unwritable_logs.front();
  const std::size_t more = facts.unwritable_logs.size() - 1;
  check.health = CheckStatus::kError;
  check.reason = fmt::format("{} belongs to {}: what its process prints is lost{}", first.path,
                             first.owner, more == 0 ? "" : fmt::format(" (and {} more)", more));
  check.fix = "sudo chown -R \"$USER\" " + ShellWord(first.path.substr(0, first.path.rfind('/')));
  return check;
}

}  // namespace

std::vector<DoctorCheck> CheckStorage(const DoctorFacts& facts) {
  return {CheckStateFolder(facts), CheckDisk(facts), CheckLock(facts), CheckLogs(facts)};
}

}  // namespace musher::cli
