#include "musher/actuator/checkpoints.hpp"

#include <algorithm>
#include <utility>

namespace musher {
namespace {

constexpr Duration kSoonest = Milliseconds(5);

// How often a thread with this allowance is checked.
Duration PeriodOf(Duration allowance) {
  return std::max(allowance / 4, kSoonest);
}

}  // namespace

Checkpoints::Checkpoints(const ActuatorConfig& config, Sample sample)
    : config_(config), sample_(std::move(sample)) {}

void Checkpoints::OnWorker(pid_t thread) {
  const std::lock_guard lock(mutex_);
  worker_ = thread;
}

Checkpoints::Watched Checkpoints::Watch(bool on, pid_t thread, Duration allowance, Time now) {
  Watched watched;
  watched.on = on;
  watched.thread = thread;
  watched.allowance = allowance;
  watched.last = watched.looked = now;
  return watched;
}

void Checkpoints::Begin(const State& state, Time now) {
  const std::lock_guard lock(mutex_);
  own_ = {};
  during_ = state;
  const auto longer = config_.checkpoint_in.find(state);
  usual_ = longer != config_.checkpoint_in.end() ? longer->second
                                                 : config_.checkpoint.value_or(Duration::zero());
  callback_ = Watch(usual_ != Duration::zero(), 0, usual_, now);
}

void Checkpoints::End() {
  const std::lock_guard lock(mutex_);
  during_ = {};
  callback_ = {};
  own_ = {};
}

void Checkpoints::Mark(pid_t thread, Duration allowance, Time now) {
  const std::lock_guard lock(mutex_);
  const bool in_callback = !during_.empty() && thread == worker_;
  if (allowance == Duration::zero()) {
    allowance = in_callback ? usual_ : config_.checkpoint.value_or(Duration::zero());
  }
  const bool on = allowance != Duration::zero() && allowance != Duration::max();
  if (in_callback) {
    callback_ = Watch(on, thread, allowance, now);
  } else if (on) {
    own_[thread] = Watch(on, thread, allowance, now);
  } else {
    own_.erase(thread);
  }
}

Checkpoints::Look Checkpoints::Evaluate(Time now) {
  const std::lock_guard lock(mutex_);
  callback_.thread = worker_;
  if (callback_.on) return EvaluateOne(callback_, during_, now);
  Look worst;
  for (auto& [thread, watched] : own_) {
    const Look look = EvaluateOne(watched, "", now);
    const bool longer = look.work == worst.work && look.silent > worst.silent;
    if (look.work > worst.work || longer) worst = look;
  }
  return worst;
}

// The lock must be held.
Checkpoints::Look Checkpoints::EvaluateOne(Watched& watched, const State& during, Time now) const {
  Look look;
  look.during = during;
  look.silent = now - watched.last;
  const Duration waited = std::max(watched.waited, WaitOf(watched, now));
  const Duration due = PeriodOf(watched.allowance);
  const Duration late = now - watched.looked - due;
  if (late > due / 2)
    watched.unseen += std::max(late - (waited - watched.waited), Duration::zero());
  watched.waited = waited;
  watched.looked = now;
  look.waited = std::min(waited + watched.unseen, look.silent);
  look.work = EvaluateSilence(look.silent, watched.allowance, look.waited);
  return look;
}

// How long it waited for a CPU and the disk since the first sample of the kernel's counters.
Duration Checkpoints::WaitOf(Watched& watched, Time now) const {
  if (now - watched.last <= watched.allowance / 2) return {};
  const auto sample = sample_(now);
  if (!watched.before) watched.before = sample;
  if (!sample || !watched.before) return {};
  const Wait wait = WaitOfThread({*watched.before, *sample}, watched.thread);
  return wait.cpu + std::min(wait.disk, kLongestDiskWait);
}

std::optional<Duration> Checkpoints::Period() const {
  const std::lock_guard lock(mutex_);
  std::optional<Duration> period;
  const auto take = [&period](const Watched& watched) {
    const Duration one = PeriodOf(watched.allowance);
    period = std::min(period.value_or(one), one);
  };
  if (callback_.on) take(callback_);
  for (const auto& [thread, watched] : own_) take(watched);
  return period;
}

}  // namespace musher
