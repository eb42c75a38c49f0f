#include "musher/cli/machine/process_facts.hpp"

#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "musher/base/files.hpp"
#include "musher/base/scheduling.hpp"
#include "musher/cli/console/wall_time.hpp"

namespace musher::cli {

std::optional<ProcessFacts> FactsOf(pid_t pid) {
  const auto usage = UsageOf(pid);
  if (!usage) return std::nullopt;
  ProcessFacts facts;
  facts.usage = *usage;
  const std::string folder = "/proc/" + std::to_string(pid);
  facts.command = ReadFile(folder + "/cmdline");
  std::replace(facts.command.begin(), facts.command.end(), '\0', ' ');
  while (facts.command.ends_with(' ')) facts.command.pop_back();
  std::error_code error;
  facts.cwd = std::filesystem::read_symlink(folder + "/cwd", error);
  timespec boot{};
  clock_gettime(CLOCK_BOOTTIME, &boot);
  const double now_s = static_cast<double>(boot.tv_sec) + static_cast<double>(boot.tv_nsec) / 1e9;
  const auto ticks = static_cast<double>(sysconf(_SC_CLK_TCK));
  facts.age_s = std::max(0.0, now_s - static_cast<double>(usage->start_time) / ticks);
  facts.started_wall_ns = WallNow() - static_cast<std::int64_t>(facts.age_s * 1e9);
  const auto state = RunStateOf(pid);
  facts.stopped = state == ProcessRunState::kStopped || state == ProcessRunState::kTraced;
  return facts;
}

}  // namespace musher::cli
