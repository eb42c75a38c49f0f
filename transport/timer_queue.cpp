#include "musher/transport/timer_queue.hpp"

namespace musher::transport {

class TimerQueue::Handle : public LoopHandle {
 public:
  Handle(TimerQueue& queue, std::shared_ptr<Timer> timer)
      : queue_(queue), timer_(std::move(timer)) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() override { queue_.timers_.erase({timer_->when, timer_->number}); }

 private:
  TimerQueue& queue_;
  std::shared_ptr<Timer> timer_;
};

LoopHandlePtr TimerQueue::Add(Time when, Duration period, std::function<void()> callback) {
  auto timer = std::make_shared<Timer>(Timer{0, when, period, std::move(callback)});
  Insert(timer);
  return std::make_unique<Handle>(*this, std::move(timer));
}

std::optional<Time> TimerQueue::NextDue() const {
  if (timers_.empty()) return std::nullopt;
  return timers_.begin()->first.first;
}

bool TimerQueue::RunNext(Time now) {
  if (timers_.empty() || timers_.begin()->first.first > now) return false;
  // Held here, because the callback may drop the handle and with it the last other owner.
  const std::shared_ptr<Timer> timer = timers_.begin()->second;
  timers_.erase(timers_.begin());
  if (timer->period > Duration::zero()) {
    const auto missed = (now - timer->when) / timer->period;
    timer->when += timer->period * (missed + 1);
    Insert(timer);
  }
  timer->callback();
  return true;
}

void TimerQueue::Shift(Duration by) {
  std::map<Key, std::shared_ptr<Timer>> shifted;
  for (auto& [key, timer] : timers_) {
    timer->when += by;
    shifted.emplace_hint(shifted.end(), Key{timer->when, timer->number}, timer);
  }
  timers_ = std::move(shifted);
}

void TimerQueue::Insert(const std::shared_ptr<Timer>& timer) {
  timer->number = next_number_++;
  timers_.emplace(Key{timer->when, timer->number}, timer);
}

}  // namespace musher::transport
