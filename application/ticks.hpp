#pragma once
// What the actuators of this folder have in common: ticks on the machine's clock, hooks whose
// exceptions become texts, and a log that a fault in each tick does not fill.

#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/transport/loop_breaks.hpp"

namespace musher {

// Calls a hook; nullopt, or the text of its exception.
template <class Hook>
std::optional<std::string> Thrown(const char* name, const Hook& hook) {
  try {
    hook();
    return std::nullopt;
  } catch (const std::exception& thrown) {
    return std::string(name) + ": " + thrown.what();
  } catch (...) {
    return std::string(name) + ": threw something that is not a std::exception";
  }
}

// The clock of an actuator's endpoints, and the timer of its ticks. Before Open() and after the
// endpoints are closed there is no clock: Now() is Time{}, and nothing ticks. Loop thread only.
class Ticks {
 public:
  void Open(transport::Endpoints& topics) {
    const auto wire = std::make_shared<Wire>(topics.node().loop());
    wire->clock = &topics.clock();
    topics.Keep(wire);
    wire_ = wire;
  }
  bool open() const { return !wire_.expired(); }

  void Start(double rate_hz, std::function<void()> tick) {
    const auto wire = wire_.lock();
    if (!wire) return;
    const std::chrono::duration<double> period(1 / rate_hz);
    wire->ticks = wire->clock->Every(std::chrono::duration_cast<Duration>(period), std::move(tick));
  }
  void Stop() {
    if (const auto wire = wire_.lock()) wire->ticks.reset();
  }

  // Ends the process when another thread than the loop's asks for what is changed by ticks.
  void CheckThread() const {
    if (const auto wire = wire_.lock()) wire->loop->CheckThread();
  }

  Time Now() const {
    const auto wire = wire_.lock();
    return wire ? wire->clock->Now() : Time{};
  }
  msg::Stamp Stamp() const {
    const auto wire = wire_.lock();
    return wire ? wire->clock->Stamp() : msg::Stamp{};
  }
  // The steady time of the loop, whatever the machine's clock does.
  Time LoopNow() const {
    const auto wire = wire_.lock();
    return wire ? wire->loop->Now() : Time{};
  }
  // How long this process could not run just now, see BreakWatch.
  std::optional<Duration> RecentBreak() const {
    const auto wire = wire_.lock();
    return wire ? wire->breaks.Recent() : std::nullopt;
  }
  // The longest such break since the last call, whenever it was; for what runs.
  std::optional<Duration> TakeBreak() const {
    const auto wire = wire_.lock();
    return wire ? wire->breaks.Take() : std::nullopt;
  }
  // Runs `work` after the present handler, unless the endpoints are closed by then.
  void Post(std::function<void()> work) const {
    const auto wire = wire_.lock();
    if (!wire) return;
    wire->loop->Post([still = wire_, work = std::move(work)] {
      if (still.lock()) work();
    });
  }

 private:
  struct Wire {
    explicit Wire(transport::EventLoop& own) : loop(&own), breaks(own) {}

    transport::EventLoop* loop;
    transport::Clock* clock = nullptr;
    transport::LoopHandlePtr ticks;
    transport::LoopBreaks breaks;
  };

  std::weak_ptr<Wire> wire_;  // the endpoints keep it
};

// At most so many lines within a second of `at`, so that a fault in each tick does not fill the
// disk.
class LimitedLog {
 public:
  explicit LimitedLog(const MachineActuator& owner) : owner_(owner) {}

  void operator()(Duration at, LogLevel level, const std::string& line) {
    if (at < since_ || at - since_ >= std::chrono::seconds(1)) {
      since_ = at;
      lines_ = 0;
    }
    if (++lines_ <= kMost) owner_.Log(level, line);
    if (lines_ == kMost) owner_.Log(level, "further messages within this second are suppressed");
  }

 private:
  static constexpr int kMost = 20;

  const MachineActuator& owner_;
  Duration since_{};
  int lines_ = 0;
};

}  // namespace musher
