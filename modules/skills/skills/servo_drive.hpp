#pragma once
// Drives a robot on the ground by a VisualServo: asks its detectors, sends the velocity of each
// step, and says when the target is right or why it cannot be. Without odometry, scan or a sighting
// that counts the robot stands.
//
// Metres, radians, in the frame of the body. Threads: those of robot.hpp.

#include <optional>
#include <string>

#include "musher/base/time.hpp"
#include "musher/modules/skills/robot/robot.hpp"
#include "musher/modules/skills/skills/visual_servo.hpp"

namespace musher::skills {

struct ServoDriveStep {
  enum class Kind : std::uint8_t { kPending, kReached, kFailed };

  Kind kind = Kind::kPending;
  std::string text{};                         // what it does, or why it has failed
  std::optional<navigation::Point> target{};  // of kReached the mean of its sightings at the stand
};

class ServoDrive {
 public:
  // `lost_limit_s`: at a stand, then it fails.
  ServoDrive(Robot& robot, const ServoRules& rules, double lost_limit_s)
      : robot_(robot), rules_(rules), servo_(rules), lost_limit_s_(lost_limit_s) {}

  // `step`: the time since the last one.
  ServoDriveStep Step(Duration step);
  // Where the target was when it was seen last: "1.40 m away, 0.10 rad to the left".
  std::string PlaceText() const;

 private:
  // Nullopt: nothing is missing.
  std::optional<std::string> Missing() const;
  ServoDriveStep Stand(Duration step, const std::string& why);

  Robot& robot_;
  const ServoRules rules_;
  VisualServo servo_;
  const double lost_limit_s_;
  std::optional<navigation::Point> target_;
  Duration standing_{};
  Duration blocked_{};
};

}  // namespace musher::skills
