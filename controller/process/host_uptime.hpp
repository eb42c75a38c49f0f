#pragma once
// How long another host has run, by its own clock, as the shell of that host reads it: the bound of
// what is carried out there late. The kernel may deliver what was written to a connection minutes
// after that was lost, and no clock of two hosts is the same.
//
// Threads: any.

#include <string>
#include <vector>

#include "musher/base/time.hpp"

namespace musher {

// For sh: sets $running to the seconds that the first process has run, which is the uptime but in a
// container.
inline constexpr const char* kReadRunning =
    "read -r up idle </proc/uptime; read -r first </proc/1/stat; set -- ${first##*) }; "
    "running=$((${up%%.*} - ${20} / 100)); ";

// A program that succeeds while the host has run for no longer than this.
inline std::vector<std::string> UntilHostHasRun(Duration limit) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(limit).count();
  return {"/bin/sh", "-c",
          std::string(kReadRunning) + "[ \"$running\" -le " + std::to_string(seconds) + " ]"};
}

}  // namespace musher
