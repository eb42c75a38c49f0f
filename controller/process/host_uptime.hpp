#pragma once
// Keeps another host from carrying out a start late. The kernel may deliver what was written to a
// connection minutes after the connection was lost. The next connection ends the old one on that
// host. If no connection follows, a start still has a limit: the time for which the host has run,
// as the shell there reads it, because the clocks of two hosts differ.
//
// Threads: any.

#include <sys/types.h>
#include <time.h>

#include <chrono>
#include <string>
#include <vector>

#include "musher/base/time.hpp"

namespace musher {

// For how long this host has run, also while it was suspended.
inline Duration SinceBoot() {
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

// For sh: sets $running to the seconds that the first process has run, which is the uptime but in a
// container. A host whose /proc hides that process (hidepid) is no container: it is the uptime.
inline constexpr const char* kReadRunning =
    "read -r up idle </proc/uptime; first=; { read -r first </proc/1/stat; } 2>/dev/null; "
    "set -- ${first##*) }; running=$((${up%%.*} - ${20:-0} / 100)); ";

// A program that succeeds while the host has run for no longer than this.
inline std::vector<std::string> UntilHostHasRun(Duration limit) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(limit).count();
  return {"/bin/sh", "-c",
          std::string(kReadRunning) + "[ \"$running\" -le " + std::to_string(seconds) + " ]"};
}

// For sh: kills `bridge`, the other end of an earlier connection, with all that it has not
// delivered, if it still runs and its host is still in the boot `boot_id`.
inline std::string EndBridge(const std::string& boot_id, pid_t bridge) {
  const std::string pid = std::to_string(bridge);
  return "[ \"$(cat /proc/sys/kernel/random/boot_id)\" = " + boot_id + " ] && [ \"$(cat /proc/" +
         pid + "/comm 2>/dev/null)\" = systemd-stdio-b ] && kill " + pid + " 2>/dev/null; ";
}

}  // namespace musher
