#pragma once
// A simulated dog without processes: the world's body behind the decision code of the motion
// manager, in steps of the world's 20 ms.
//
// Threads: one at a time.

#include <cstdint>
#include <functional>
#include <map>

#include "musher/messages/protocol/motion.hpp"
#include "musher/modules/motion/motion_core.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::race::testing {

class SimulatedDog {
 public:
  using OnDone = std::function<void(std::int32_t code)>;

  explicit SimulatedDog(world::Scene scene);

  void Servo(const msg::MotionServoCmd& frame);
  // One motion of the table; `on_done` gets its code in a later step.
  void Play(std::int32_t motion_id, OnDone on_done);
  void Step();

  // The motion that the body executes, as in motion_status.
  std::int32_t present_motion() const;

  std::function<void(const msg::MotionServoResponse&)> on_servo_reply;

  const world::World& world() const { return world_; }
  world::World& world() { return world_; }
  Time now() const { return Time(world_.now()); }
  // The last refusals and faults of the motion manager.
  const std::vector<std::string>& log() const { return log_; }

 private:
  void Take(const motion::MotionEvent& event);
  void Report();
  motion::MotionRules Rules() const { return {table_, config_, allowed_}; }

  const motion::MotionTable table_;
  const motion::MotionConfig config_;
  const motion::Gate allowed_ = [](const std::string&) { return Ok(); };
  world::World world_;
  motion::MotionCore core_;
  motion::RequestToken last_token_ = 0;
  std::map<motion::RequestToken, OnDone> waiting_;
  std::vector<std::string> log_;
};

}  // namespace musher::race::testing
