#pragma once
// Whether a controller of this host that does not answer is short of CPU time. Then its silence
// does not mean that it hangs, and a command waits longer for it.

#include <sys/types.h>

#include <optional>

#include "musher/base/scheduling.hpp"

namespace musher::cli {

// The time between two samples.
inline constexpr Duration kShortageWindow = std::chrono::seconds(1);
// The most that a command waits for a controller that is short of CPU time.
inline constexpr Duration kLongestShortage = std::chrono::seconds(60);

enum class CpuShortage {
  kNone,
  kOfController,
  kOfCommand,  // of the process that waits: the host has no CPU time for either
};

// Of the controller and of the process that waits for it, at one time.
struct ShortageSample {
  std::optional<ProcessSample> controller;  // none: it has exited, is stopped, or cannot be read
  std::optional<ProcessSample> command;
};

ShortageSample SampleShortage(pid_t controller, Time now);
// Between two samples.
CpuShortage FindShortage(const ShortageSample& before, const ShortageSample& after);

}  // namespace musher::cli
