#include "musher/base/process_usage.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <string>

#include "musher/base/files.hpp"

namespace musher {
namespace {

// Fields of /proc/<pid>/stat after the name of the program, counted from 0 (proc(5) counts from 3).
constexpr int kUserTime = 11;
constexpr int kSystemTime = 12;
constexpr int kThreads = 17;
constexpr int kStartTime = 19;
constexpr int kResident = 21;

}  // namespace

std::optional<ProcessUsage> ParseUsage(pid_t pid, std::string_view stat, double ticks_per_second,
                                       std::uint64_t page_bytes) {
  // The name is in parentheses and may contain any byte, ')' too.
  const auto name_end = stat.rfind(')');
  if (name_end == std::string_view::npos) return std::nullopt;
  stat.remove_prefix(name_end + 1);
  std::uint64_t ticks = 0;
  ProcessUsage usage{pid};
  for (int field = 0; field <= kResident; ++field) {
    const auto begin = stat.find_first_not_of(' ');
    if (begin == std::string_view::npos) return std::nullopt;
    stat.remove_prefix(begin);
    const auto end = std::min(stat.find(' '), stat.size());
    if (field == kUserTime || field == kSystemTime || field == kThreads || field == kStartTime ||
        field == kResident) {
      std::uint64_t value = 0;
      if (std::from_chars(stat.data(), stat.data() + end, value).ec != std::errc()) {
        return std::nullopt;
      }
      if (field == kUserTime || field == kSystemTime) ticks += value;
      if (field == kThreads) usage.threads = value;
      if (field == kStartTime) usage.start_time = value;
      if (field == kResident) usage.resident_bytes = value * page_bytes;
    }
    stat.remove_prefix(end);
  }
  usage.cpu_seconds = static_cast<double>(ticks) / ticks_per_second;
  return usage;
}

std::optional<ProcessUsage> UsageOf(pid_t pid) {
  if (pid <= 0) return std::nullopt;
  const std::string stat = ReadFile("/proc/" + std::to_string(pid) + "/stat");
  return ParseUsage(pid, stat, static_cast<double>(sysconf(_SC_CLK_TCK)),
                    static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)));
}

}  // namespace musher
