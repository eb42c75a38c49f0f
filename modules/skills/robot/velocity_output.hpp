#pragma once
// The velocity commands of a robot: the last one goes through the gate and is published 20 times a
// second, with each scan, and with each range below it while it descends, until it is replaced or
// stopped. Stop() publishes 0 once and then nothing more; without commands the robot itself stops.
//
// A body on the ground whose odometry cannot be true beside its commands is stopped as well, until
// Stop(): it is commanded and does not move, for example before a thing below its scanner; its pose
// jumps; it is carried or pushed. A person who teleoperates it releases the stick once, and goes
// on.
//
// A command of a person (teleop) is used only while no skill sends one, and ends by itself after
// kTeleopTime.
//
// Threads: the loop's.

#include <optional>
#include <string>
#include <vector>

#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/sensor_msgs/laser_scan.hpp"
#include "musher/messages/sensor_msgs/range.hpp"
#include "musher/navigation/frames/frame_tree.hpp"
#include "musher/navigation/gate/motion_gate.hpp"
#include "musher/navigation/gate/motion_guard.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/node.hpp"

namespace musher::skills {

class VelocityOutput {
 public:
  static constexpr Duration kPeriod = Milliseconds(50);
  static constexpr Duration kTeleopTime = Milliseconds(500);

  // Both must outlive it. Null: there is no publisher.
  VelocityOutput(transport::Publisher<msg::Twist>* publisher, transport::Clock& clock,
                 const navigation::GateRules& rules, const navigation::GuardRules& limits,
                 bool flies)
      : publisher_(publisher), clock_(clock), gate_(rules), flies_(flies), guard_(limits) {}

  // False: the scan is refused.
  bool OnScan(std::size_t scanner, const msg::LaserScan& scan);
  // Of the sensor that looks down.
  void OnRange(const msg::Range& range);
  // The height of the ground on which it shall land, in the frame of its odometry; until Stop().
  void ExpectGround(double height_m) { gate_.ExpectGround(height_m); }
  // A flyer has to land, also where it does not see.
  void MustLand(bool must) { gate_.MustLand(must); }
  // Where the scanner is on the body, as a transform says.
  void Mount(std::size_t scanner, const navigation::FramePlacement& placement) {
    gate_.Mount(scanner, placement.pose, placement.upside_down);
  }
  // What the scanner has seen last, in the frame of the body.
  const std::vector<navigation::Point>& PointsOf(std::size_t scanner) const {
    return gate_.PointsOf(scanner);
  }
  // Whether a recent scan covers this place, in the frame of the body.
  bool Covers(const navigation::Point& place) const { return gate_.Covers(place, clock_.Now()); }
  // As measured: the pose in any frame that stays, the velocity in the frame of the body.
  // `stamp`: of the message; 0: it has none.
  void OnMotion(const navigation::Pose& pose, const navigation::Velocity& velocity, Duration stamp);

  void Set(const navigation::Velocity& command);
  void Teleoperate(const navigation::Velocity& command);
  void Stop();

  // Whether a skill, or a person, moves the robot.
  bool sending() const { return sending_ != nullptr; }
  // Whether it is a person who does.
  bool teleoperated() const { return teleop_until_.has_value(); }
  // The command that was sent last.
  const navigation::Velocity& passed() const { return verdict_.command; }
  // What the gate stops it for; empty: nothing.
  std::string HeldBy() const;
  // Why a flyer does not descend as commanded; empty: it does.
  std::string WhyNotDescending() const { return verdict_.careful ? "" : verdict_.descent; }

 private:
  void Send(const navigation::Velocity& command);
  void Hold(const Error& fault);
  void Publish();

  transport::Publisher<msg::Twist>* const publisher_;
  transport::Clock& clock_;
  navigation::MotionGate gate_;
  const bool flies_;  // then it holds its place in the wind, and its commands move it nowhere
  navigation::MotionGuard guard_;
  std::string fault_;  // of the odometry beside the commands; empty: none
  navigation::Velocity command_;
  navigation::GateVerdict verdict_;
  std::optional<Time> teleop_until_;
  transport::LoopHandlePtr sending_;
};

}  // namespace musher::skills
