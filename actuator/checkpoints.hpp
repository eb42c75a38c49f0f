#pragma once
// Watches that an actuator's own threads get on: the worker while it runs a callback, and whatever
// thread of the module has begun to give checkpoints.
//
//   a callback begins ──▶ watched: a checkpoint is due within its state's allowance ──▶ it ends
//   a thread gives a checkpoint ──▶ the next is due within its allowance ──▶ a callback begins, or
//                                                                            it says kNoMore
//
// A thread is only charged with the time in which it could have run: what it waited for a CPU, by
// the kernel's books, does not count. The books are opened when half its allowance is over. Nor
// does time count in which this process could not even look (it was stopped, or its machine was):
// of a look that comes late only the quarter of the allowance after which it was due is charged. So
// a hang is found within five looks, however late each comes.
//
// Threads: Mark() and OnWorker() from any; the rest from the loop.

#include <sys/types.h>

#include <functional>
#include <mutex>
#include <optional>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/health.hpp"
#include "musher/transport/scheduling.hpp"

namespace musher {

class Checkpoints {
 public:
  // A look at the threads of this process; nullopt where there is none to be had.
  using Sample = std::function<std::optional<transport::ProcessSample>(Time now)>;

  Checkpoints(const ActuatorConfig& config, Sample sample);

  // The callback of `state` is handed to the worker, or has ended.
  void Begin(const State& state, Time now);
  void End();
  // Which thread the worker's is; said by it as a callback begins.
  void OnWorker(pid_t thread);

  // `thread` got on; it will again within `allowance` (zero: as the config says).
  void Mark(pid_t thread, Duration allowance, Time now);

  struct Look {
    Health work = Health::kWell;
    State during;       // whose callback runs; empty for work of the module's own
    Duration silent{};  // since the last checkpoint
    Duration waited{};  // so much of it the thread waited for a CPU, or nobody was there to look
  };
  Look Judge(Time now);

  // How often to look so that a hang is seen soon after its allowance; nullopt: nothing is watched.
  std::optional<Duration> Period() const;

 private:
  struct Watched {
    bool on = false;
    pid_t thread = 0;
    Time last{};
    Duration allowance{};
    Time looked{};      // when it was judged last
    Duration waited{};  // for a CPU, by then
    Duration unseen{};  // that looks came too late, beyond what it waited
    std::optional<transport::ProcessSample> before;  // from when half the allowance was over
  };

  static Watched Watch(bool on, pid_t thread, Duration allowance, Time now);
  Look EvaluateOne(Watched& watched, const State& during, Time now) const;
  Duration WaitOf(Watched& watched, Time now) const;

  const ActuatorConfig& config_;
  const Sample sample_;
  mutable std::mutex mutex_;  // guards the rest
  State during_;              // whose callback runs; empty: none
  Duration usual_{};          // its allowance by the config; zero: none
  pid_t worker_ = 0;
  Watched callback_;
  Watched own_;
};

}  // namespace musher
