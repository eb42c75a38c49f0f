#pragma once
// The time that a module's behaviour follows: the steady time of its loop, or the topic /clock of a
// simulated world, as ROS 2's use_sim_time has it. Deadlines of switches, leases and restarts are
// the loop's own and never follow /clock.
//
// On /clock, time is what the last sample said, and stands still between samples: a timer fires
// when a sample reaches it, so a world that runs five times as fast fires it five times as often.
// Before the first sample Now() is Time{} and nothing fires. When time jumps - at the first sample,
// or backwards because the world was restarted - every timer keeps the time that was left to it.
//
// Threads: the loop's only. Handles must be gone before their clock, a clock before its node. A
// callback may drop any handle, its own too, but not the clock.

#include <functional>
#include <memory>

#include "musher/lifecycle/config.hpp"
#include "musher/messages/builtin_interfaces/time.hpp"
#include "musher/transport/node.hpp"

namespace musher::transport {

inline constexpr Qos kClockQos{Qos::Reliability::kBestEffort, Qos::Durability::kVolatile, 1};
inline constexpr const char* kClockTopic = "clock";  // whatever the namespace

class Clock {
 public:
  virtual ~Clock() = default;

  static std::unique_ptr<Clock> Steady(EventLoop& loop);

  // `on_jump_back` runs when the world was restarted, before anything fires at the new time.
  static Result<std::unique_ptr<Clock>> FromTopic(Node& node,
                                                  std::function<void()> on_jump_back = {});

  // The one that the machine goes by.
  static Result<std::unique_ptr<Clock>> Of(const MachineConfig& config, Node& node,
                                           std::function<void()> on_jump_back = {});

  // On /clock: Time{} plus what the world's clock shows.
  virtual Time Now() const = 0;

  // Now, as the messages of modules are stamped: what /clock shows, else the time of day. Not for
  // measuring: a time of day may be set.
  virtual msg::Stamp Stamp() const = 0;

  // Runs `callback` once, at `when` or as soon after as the clock comes to it.
  virtual LoopHandlePtr At(Time when, std::function<void()> callback) = 0;

  // Runs `callback` every `period`, first one period from now. Missed periods are not made up for.
  virtual LoopHandlePtr Every(Duration period, std::function<void()> callback) = 0;
};

}  // namespace musher::transport
