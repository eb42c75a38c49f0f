#pragma once
// The time that a module's behaviour follows: the steady time of its loop, or the topic /clock of a
// simulated world, like ROS 2's use_sim_time. Deadlines of switches, leases and restarts use the
// loop's time and never follow /clock.
//
// On /clock, time is the last sample and stands still between samples: a timer fires when a sample
// reaches it, so a world that runs five times as fast fires it five times as often. Before the
// first sample Now() is Time{} and nothing fires. When time jumps - at the first sample, backwards
// because the world was restarted, or forwards by more than 10 s between two samples because a
// recording was skipped - every timer keeps its remaining time.
//
// Threads: loop thread only. Handles must be dropped before their clock, a clock before its node. A
// callback may drop any handle, its own too, but not the clock.

#include <functional>
#include <memory>
#include <string>

#include "musher/base/network_profile.hpp"
#include "musher/messages/builtin_interfaces/time.hpp"
#include "musher/transport/node.hpp"

namespace musher::transport {

inline constexpr Qos kClockQos{Qos::Reliability::kBestEffort, Qos::Durability::kVolatile, 1};
inline constexpr const char* kClockTopic = "clock";  // in every namespace

class Clock {
 public:
  virtual ~Clock() = default;

  static std::unique_ptr<Clock> Steady(EventLoop& loop);

  // `on_jump` runs when the time has jumped, except at the first sample, before any timer fires at
  // the new time.
  static Result<std::unique_ptr<Clock>> FromTopic(Node& node, std::function<void()> on_jump = {});

  static Result<std::unique_ptr<Clock>> Of(ClockSource source, Node& node,
                                           std::function<void()> on_jump = {});

  // On /clock: Time{} plus the last sample.
  virtual Time Now() const = 0;

  // Now, for the stamps of messages: the time of /clock, else the time of day. Not for measuring:
  // the time of day may be set.
  virtual msg::Stamp Stamp() const = 0;

  // Why the time has jumped the last time, for people: "the time of /clock went back by 60.00 s",
  // or that several programs publish it. Empty: it has not, or this clock does not say.
  virtual std::string JumpText() const { return ""; }

  // Runs `callback` once, at `when` or as soon as possible after it.
  virtual LoopHandlePtr At(Time when, std::function<void()> callback) = 0;

  // Runs `callback` every `period`, first one period from now. Skips missed periods.
  virtual LoopHandlePtr Every(Duration period, std::function<void()> callback) = 0;
};

}  // namespace musher::transport
