#pragma once
// A simulated dog without processes: the world's body behind the decision code of the motion
// manager, in steps of the world's 20 ms. Commands and reports are values of this process; or they
// are datagrams of LCM on the loopback of this computer, between the motion manager's link and the
// world's motion board, which have the virtual time of these steps, too.
//
// Threads: one at a time.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>

#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/modules/motion/motion_backend.hpp"
#include "musher/modules/motion/motion_core.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::race::testing {

class SimulatedDog {
 public:
  using OnDone = std::function<void(std::int32_t code)>;

  enum class Wire : std::uint8_t { kNone, kLcm };

  explicit SimulatedDog(world::Scene scene, Wire wire = Wire::kNone);
  ~SimulatedDog();

  void Servo(const msg::MotionServoCmd& frame);
  // One motion of the table; `on_done` gets its code in a later step.
  void Play(std::int32_t motion_id, OnDone on_done);
  void Step();

  // The motion that the body executes, as in motion_status, and its switch_status.
  std::int32_t present_motion() const;
  int body_status() const;
  // As the motion manager publishes it.
  msg::Odometry odometry() const;
  // Datagrams of both ways so far.
  std::size_t datagrams() const;

  std::function<void(const msg::MotionServoResponse&)> on_servo_reply;

  const world::World& world() const { return world_; }
  world::World& world() { return world_; }
  Time now() const { return Time(world_.now()); }
  // The last refusals and faults of the motion manager.
  const std::vector<std::string>& log() const { return log_; }

 private:
  class LcmWire;

  void Take(const motion::MotionEvent& event);
  void Report();
  motion::MotionRules Rules() const { return {table_, config_, allowed_}; }

  const motion::MotionTable table_;
  const motion::MotionConfig config_;
  const motion::Gate allowed_ = [](const std::string&) { return Ok(); };
  world::World world_;
  motion::BodyState body_;  // by the wire
  motion::MotionCore core_;
  motion::RequestToken last_token_ = 0;
  std::map<motion::RequestToken, OnDone> waiting_;
  std::vector<std::string> log_;
  std::unique_ptr<LcmWire> wire_;  // null: none. Last: its callbacks use the rest
};

}  // namespace musher::race::testing
