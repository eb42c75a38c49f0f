#pragma once
// What a process of this host uses, from the kernel.
//
// Threads: any. Nothing throws; nullopt if there is no such process or it is not visible to us.

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string_view>

namespace musher {

struct ProcessUsage {
  pid_t pid = 0;
  std::uint64_t start_time = 0;  // ticks since boot; differs for a later process of the same pid
  double cpu_seconds = 0;        // of all its threads, user and system, since its start
  std::uint64_t resident_bytes = 0;
  std::uint64_t threads = 0;

  friend bool operator==(const ProcessUsage&, const ProcessUsage&) = default;
};

std::optional<ProcessUsage> UsageOf(pid_t pid);

// The same from the text of /proc/<pid>/stat.
std::optional<ProcessUsage> ParseUsage(pid_t pid, std::string_view stat, double ticks_per_second,
                                       std::uint64_t page_bytes);

}  // namespace musher
