#include "musher/cli/machine/cpu_shortage.hpp"

#include <unistd.h>

namespace musher::cli {
namespace {

// A thread that waits for a CPU for this part of the time is short of it. An idle host gives a CPU
// within microseconds.
constexpr int kPart = 5;

bool IsShort(const std::optional<ProcessSample>& before,
             const std::optional<ProcessSample>& after) {
  if (!before || !after) return false;
  return LongestWait(*before, *after) * kPart >= after->at - before->at;
}

}  // namespace

ShortageSample SampleShortage(pid_t controller, Time now) {
  ShortageSample sample{SampleProcess(controller, now), SampleProcess(getpid(), now)};
  if (RunStateOf(controller) != ProcessRunState::kRunning) sample.controller.reset();
  return sample;
}

CpuShortage FindShortage(const ShortageSample& before, const ShortageSample& after) {
  if (!before.controller || !after.controller) return CpuShortage::kNone;
  if (IsShort(before.controller, after.controller)) return CpuShortage::kOfController;
  return IsShort(before.command, after.command) ? CpuShortage::kOfCommand : CpuShortage::kNone;
}

}  // namespace musher::cli
