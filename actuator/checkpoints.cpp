#include "musher/actuator/checkpoints.hpp"

#include <algorithm>
#include <utility>

namespace musher {
namespace {

constexpr Duration kSoonest = Milliseconds(5);

}  // namespace

Checkpoints::Checkpoints(const ActuatorConfig& config, Sample sample)
    : config_(config), sample_(std::move(sample)) {}

void Checkpoints::OnWorker(pid_t thread) {
  const std::lock_guard lock(mutex_);
  worker_ = thread;
}

void Checkpoints::Begin(const State& state, Time now) {
  const std::lock_guard lock(mutex_);
  own_ = {};
  during_ = state;
  const auto longer = config_.checkpoint_in.find(state);
  usual_ = longer != config_.checkpoint_in.end() ? longer->second
                                                 : config_.checkpoint.value_or(Duration::zero());
  callback_ = {usual_ != Duration::zero(), 0, now, usual_, std::nullopt};
}

void Checkpoints::End() {
  const std::lock_guard lock(mutex_);
  during_.clear();
  callback_ = {};
  own_ = {};
}

void Checkpoints::Mark(pid_t thread, Duration allowance, Time now) {
  const std::lock_guard lock(mutex_);
  const bool in_callback = !during_.empty() && thread == worker_;
  Watched& watched = in_callback ? callback_ : own_;
  if (allowance == Duration::zero()) {
    allowance = in_callback ? usual_ : config_.checkpoint.value_or(Duration::zero());
  }
  const bool on = allowance != Duration::zero() && allowance != Duration::max();
  watched = {on, thread, now, allowance, std::nullopt};
}

Checkpoints::Look Checkpoints::Judge(Time now) {
  const std::lock_guard lock(mutex_);
  callback_.thread = worker_;
  if (callback_.on) return JudgeOne(callback_, during_, now);
  return own_.on ? JudgeOne(own_, "", now) : Look{};
}

// Under the lock.
Checkpoints::Look Checkpoints::JudgeOne(Watched& watched, const State& during, Time now) const {
  Look look;
  look.during = during;
  look.silent = now - watched.last;
  if (look.silent <= watched.allowance / 2) return look;
  if (!watched.before) watched.before = sample_(now);
  if (look.silent <= watched.allowance) return look;
  if (const auto after = sample_(now); after && watched.before) {
    look.waited =
        transport::ThreadWait(*watched.before, *after, watched.thread).value_or(Duration::zero());
  }
  look.work = JudgeSilence(look.silent, watched.allowance, look.waited);
  return look;
}

std::optional<Duration> Checkpoints::Period() const {
  const std::lock_guard lock(mutex_);
  std::optional<Duration> period;
  for (const Watched* watched : {&callback_, &own_}) {
    if (!watched->on) continue;
    const Duration one = std::max(watched->allowance / 4, kSoonest);
    period = period ? std::min(*period, one) : one;
  }
  return period;
}

}  // namespace musher
