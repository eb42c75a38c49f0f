#include "musher/transport/sim/sim_loop.hpp"

#include <memory>
#include <utility>

#include "musher/base/check.hpp"

namespace musher::transport::sim {

// A timer and its handle's state; shared with the event, so that the callback may drop the handle.
class SimLoop::Timer : public std::enable_shared_from_this<Timer> {
 public:
  Timer(Scheduler& scheduler, ProcessId process, Duration period, std::function<void()> callback)
      : scheduler_(scheduler), process_(process), period_(period), callback_(std::move(callback)) {}

  void Start(Time when) {
    when_ = when;
    event_ = scheduler_.Add(process_, when, [self = shared_from_this()] { self->Fire(); });
  }
  void Cancel() {
    cancelled_ = true;
    scheduler_.Cancel(event_);
  }

 private:
  void Fire() {
    if (cancelled_) return;
    if (period_ > Duration::zero()) {
      const auto missed = (scheduler_.now() - when_) / period_;
      Start(when_ + period_ * (missed + 1));
    }
    callback_();
  }

  Scheduler& scheduler_;
  ProcessId process_;
  Duration period_;
  std::function<void()> callback_;
  Time when_;
  EventId event_;
  bool cancelled_ = false;
};

class SimLoop::Handle : public LoopHandle {
 public:
  explicit Handle(std::shared_ptr<Timer> timer) : timer_(std::move(timer)) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() override { timer_->Cancel(); }

 private:
  std::shared_ptr<Timer> timer_;
};

void SimLoop::Post(std::function<void()> work) {
  scheduler_.Add(process_, scheduler_.now(), std::move(work));
}

LoopHandlePtr SimLoop::At(Time when, std::function<void()> callback) {
  auto timer = std::make_shared<Timer>(scheduler_, process_, Duration::zero(), std::move(callback));
  timer->Start(when - links_.ClockOffset(host_));
  return std::make_unique<Handle>(std::move(timer));
}

LoopHandlePtr SimLoop::Every(Duration period, std::function<void()> callback) {
  MUSHER_CHECK(period > Duration::zero(), "ns:", period.count());
  auto timer = std::make_shared<Timer>(scheduler_, process_, period, std::move(callback));
  timer->Start(scheduler_.now() + period);
  return std::make_unique<Handle>(std::move(timer));
}

LoopHandlePtr SimLoop::WhenReadable(int, std::function<void()>) {
  return std::make_unique<LoopHandle>();
}

void SimLoop::Run() {
  while (!stop_ && scheduler_.Step(Time::max())) {
  }
  stop_ = false;
}

bool SimLoop::RunUntil(const std::function<bool()>& done, Time deadline) {
  return RunEventsUntil(scheduler_, done, deadline - links_.ClockOffset(host_));
}

bool RunEventsUntil(Scheduler& scheduler, const std::function<bool()>& done, Time limit) {
  if (done()) return true;
  while (scheduler.Step(limit)) {
    if (done()) return true;
  }
  scheduler.AdvanceTo(limit);
  return false;
}

}  // namespace musher::transport::sim
