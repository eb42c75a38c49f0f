#pragma once
// Watches that an actuator's own threads make progress: the worker while it runs a callback, and
// any thread of the module that has begun to give checkpoints.
//
//   a callback begins ──▶ watched: a checkpoint is due within its state's allowance ──▶ it ends
//   a thread gives a checkpoint ──▶ the next is due within its allowance ──▶ a callback begins, or
//                                                                            it gives kNoMore
//
// Each thread is watched on its own: a thread that hangs is found although others make progress.
//
// Only time in which the thread could have run counts: the time it waited for a CPU or the disk,
// according to the kernel, does not. The kernel's counters are sampled once half the allowance is
// over. Time in which this process could not check does not count either (it was stopped, or its
// machine was): a late check counts only the quarter of the allowance after which it was due. So a
// hang is found within five checks, however late each one is.
//
// Threads: Mark() and OnWorker() from any thread; the rest from the loop.

#include <sys/types.h>

#include <functional>
#include <map>
#include <mutex>
#include <optional>

#include "musher/base/scheduling.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/health/health.hpp"

namespace musher {

class Checkpoints {
 public:
  // Samples the threads of this process; nullopt if that is not possible.
  using Sample = std::function<std::optional<ProcessSample>(Time now)>;

  Checkpoints(const ActuatorConfig& config, Sample sample);

  // The callback of `state` is passed to the worker, or has ended.
  void Begin(const State& state, Time now);
  void End();
  // The id of the worker's thread; the worker calls it when a callback begins.
  void OnWorker(pid_t thread);

  // `thread` makes progress; its next checkpoint follows within `allowance` (zero: of the config).
  void Mark(pid_t thread, Duration allowance, Time now);

  struct Look {
    Health work = Health::kWell;
    State during;       // of the running callback; empty for a thread of the module
    Duration silent{};  // since the last checkpoint
    Duration waited{};  // part of it: it waited for a CPU or the disk, or no check was possible
  };
  Look Evaluate(Time now);

  // How often to check so that a hang is found soon after its allowance; nullopt: nothing is
  // watched.
  std::optional<Duration> Period() const;

 private:
  struct Watched {
    bool on = false;
    pid_t thread = 0;
    Time last{};
    Duration allowance{};
    Time looked{};                        // of the last check
    Duration waited{};                    // for a CPU and the disk, until then
    Duration unseen{};                    // delay of late checks, in addition to `waited`
    std::optional<ProcessSample> before;  // from when half the allowance was over
  };

  static Watched Watch(bool on, pid_t thread, Duration allowance, Time now);
  Look EvaluateOne(Watched& watched, const State& during, Time now) const;
  Duration WaitOf(Watched& watched, Time now) const;

  const ActuatorConfig& config_;
  const Sample sample_;
  mutable std::mutex mutex_;  // guards the members below
  State during_;              // of the running callback; empty: none
  Duration usual_{};          // its allowance in the config; zero: none
  pid_t worker_ = 0;
  Watched callback_;
  std::map<pid_t, Watched> own_;  // by the thread; all are on
};

}  // namespace musher
