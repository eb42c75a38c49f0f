#pragma once
// A robot that is driven by velocity, on the ground or in the air: a pure model of its motion.
//
// A command is a velocity in the frame of the body: x forward, y to the left, z up, in m/s and
// rad/s. It is limited to the robot's speeds, and the velocity approaches it within the robot's
// accelerations. A command that is older than the robot's timeout counts as zero: a robot on the
// ground stops, a flyer hovers. A robot that would get into an obstacle stays where it is. A flyer
// with an empty battery sinks; a flyer that has landed does not slide, and no wind moves it.
//
// Threads: none; time and obstacles are arguments. The same seed gives the same gusts.

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>

#include "musher/modules/world/body/normal_random.hpp"
#include "musher/modules/world/scene/robot_specs.hpp"

namespace musher::world {

struct BodyVelocity {
  Eigen::Vector3d linear_m_s{0, 0, 0};  // in the frame of the body
  double turn_rad_s = 0;                // to the left
};

// Where a robot can be.
struct RobotPlace {
  // The name of what is in the way from `from_m` to `to_m`, the middles of its underside.
  std::function<std::optional<std::string>(const Eigen::Vector3d& from_m,
                                           const Eigen::Vector3d& to_m)>
      obstacle;
  std::function<double(const Eigen::Vector3d& at_m)> floor_m;  // what a flyer can land on
};

class RobotBody {
 public:
  // `seed` of its gusts.
  RobotBody(const RobotSpec& spec, std::uint64_t seed);

  // Returns the reason when the command is refused.
  std::optional<std::string> Take(const BodyVelocity& command, Duration now);

  // Stands there, on the ground, until the next command.
  void PutDown(const Eigen::Vector3d& position_m, double yaw_rad);

  void Step(const RobotPlace& place, bool battery_empty, Duration now, Duration dt);

  const Eigen::Vector3d& position_m() const { return position_m_; }  // of its underside's middle
  double yaw_rad() const { return yaw_rad_; }
  // As it moves, wind included, in the frame of the body.
  BodyVelocity velocity() const;
  bool airborne() const { return airborne_; }
  bool moving() const;
  // What stopped it in the last step; empty: it was not stopped.
  const std::string& stopped_by() const { return stopped_by_; }

 private:
  BodyVelocity Target(bool battery_empty, Duration now) const;
  void Approach(const BodyVelocity& target, double seconds);
  void Blow(double seconds);

  RobotLimits limits_;
  WindSpec wind_;
  RobotKind kind_;
  Duration command_timeout_;
  NormalRandom random_;
  BodyVelocity command_;
  Duration commanded_at_{};
  bool commanded_ = false;
  Eigen::Vector3d position_m_;
  double yaw_rad_;
  BodyVelocity velocity_;              // without the wind
  Eigen::Vector2d drift_m_s_{0, 0};    // of the wind, in the place's frame
  Eigen::Vector2d drifted_m_s_{0, 0};  // by which the wind moved it in the last step
  bool airborne_ = false;
  std::string stopped_by_;
};

}  // namespace musher::world
