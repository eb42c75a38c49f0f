#include "musher/transport/clock.hpp"

#include <optional>
#include <utility>

#include "musher/base/decimal.hpp"
#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/transport/clock_reached.hpp"
#include "musher/transport/timer_queue.hpp"

namespace musher::transport {
namespace {

class SteadyClock : public Clock {
 public:
  explicit SteadyClock(EventLoop& loop) : loop_(loop) {}

  Time Now() const override { return loop_.Now(); }
  msg::Stamp Stamp() const override {
    return msg::ToStamp(std::chrono::system_clock::now().time_since_epoch());
  }
  LoopHandlePtr At(Time when, std::function<void()> callback) override {
    return loop_.At(when, std::move(callback));
  }
  LoopHandlePtr Every(Duration period, std::function<void()> callback) override {
    return loop_.Every(period, std::move(callback));
  }

 private:
  EventLoop& loop_;
};

// A sample of the same writer that is this much older counts as reordered. An older one means that
// the writer has restarted, such as a recording played in a loop.
constexpr Duration kOvertaken = std::chrono::seconds(1);
// A longer step between two samples is a recording that was skipped, or another world: nothing was
// seen of that time. The second such step in a row counts: the clock has long steps.
constexpr Duration kLongestStep = std::chrono::seconds(10);
// Two writers whose samples come so shortly one after the other publish beside each other: a world
// that is restarted needs longer. By the steady time.
constexpr Duration kBeside = std::chrono::seconds(1);
constexpr std::uint32_t kNanosecondsInSecond = 1'000'000'000;

// `publishers`: the number of those that publish beside each other; 1: the jump is of another
// cause.
std::string TextOfJump(Duration step, int publishers) {
  const bool back = step < Duration::zero();
  const std::string by =
      Decimal(std::chrono::duration<double>(back ? -step : step).count(), 2) + " s";
  const std::string what = back ? "went back by " + by : "skipped " + by;
  if (publishers < 2) return "the time of /clock " + what;
  return std::to_string(publishers) + " programs publish /clock, and its time " + what +
         "; stop all but one";
}

class TopicClock : public Clock {
 public:
  explicit TopicClock(std::function<void()> on_jump) : on_jump_(std::move(on_jump)) {}

  Result<> Subscribe(Node& node) {
    loop_ = &node.loop();
    auto subscription = MakeSubscription<msg::Clock>(
        node, kClockTopic,
        [this](const msg::Clock& message, const SampleInfo& info) { OnSample(message, info); },
        kClockQos);
    if (!subscription) return subscription.error();
    subscription_ = std::move(subscription).value();
    // Where it is not permitted, no world waits for this process.
    auto reached = MakePublisher<msg::Clock>(node, kClockReachedTopic, kClockReachedQos);
    if (reached) reached_ = std::move(reached).value();
    return {};
  }

  Time Now() const override { return now_; }
  msg::Stamp Stamp() const override { return msg::ToStamp(now_.time_since_epoch()); }
  std::string JumpText() const override { return jump_; }
  LoopHandlePtr At(Time when, std::function<void()> callback) override {
    return timers_.Add(when, Duration::zero(), std::move(callback));
  }
  LoopHandlePtr Every(Duration period, std::function<void()> callback) override {
    return timers_.Add(now_ + period, period, std::move(callback));
  }

 private:
  void OnSample(const msg::Clock& message, const SampleInfo& info) {
    const msg::Stamp& stamp = message.clock;
    if (stamp.sec < 0 || stamp.nanosec >= kNanosecondsInSecond) return;  // invalid
    const Time time = Time{} + msg::FromStamp(stamp);
    const Time before = std::exchange(received_at_, loop_->Now());
    if (writer_ == info.writer && time <= now_ && now_ - time < kOvertaken) return Report();
    const bool first = !writer_.has_value();
    const bool skipped = time - now_ > kLongestStep && step_ <= kLongestStep;
    const bool jump = !first && (time < now_ || skipped);
    step_ = first ? Duration::zero() : time - now_;
    const bool beside = writer_ != info.writer && received_at_ - before < kBeside;
    if (jump) jump_ = TextOfJump(step_, beside ? subscription_->MatchedWriters() : 1);
    writer_ = info.writer;
    if (first || jump) timers_.Shift(time - now_);
    now_ = time;
    if (jump && on_jump_) on_jump_();
    while (timers_.RunNext(now_)) {
    }
    Report();
  }

  // The next report replaces one that could not be sent.
  void Report() {
    if (!reached_ || reached_->MatchedReaders() == 0) return;
    static_cast<void>(reached_->Publish({Stamp()}));
  }

  EventLoop* loop_ = nullptr;
  std::function<void()> on_jump_;
  std::string jump_;
  Time received_at_{};  // the last sample, by the loop's time
  Time now_{};
  Duration step_{};                   // from the sample before the last one to the last one
  std::optional<EndpointId> writer_;  // of the last sample
  TimerQueue timers_;
  std::unique_ptr<Publisher<msg::Clock>> reached_;  // null: not permitted
  std::unique_ptr<Subscription> subscription_;      // last: its callback uses the rest
};

}  // namespace

std::unique_ptr<Clock> Clock::Steady(EventLoop& loop) {
  return std::make_unique<SteadyClock>(loop);
}

Result<std::unique_ptr<Clock>> Clock::FromTopic(Node& node, std::function<void()> on_jump) {
  auto clock = std::make_unique<TopicClock>(std::move(on_jump));
  if (auto made = clock->Subscribe(node); !made) return made.error();
  return std::unique_ptr<Clock>(std::move(clock));
}

Result<std::unique_ptr<Clock>> Clock::Of(ClockSource source, Node& node,
                                         std::function<void()> on_jump) {
  if (source == ClockSource::kTopic) return FromTopic(node, std::move(on_jump));
  return Steady(node.loop());
}

}  // namespace musher::transport
