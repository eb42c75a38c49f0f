#pragma once
// The upper body of a humanoid as its motion adapter moves it: poses by name, and a gaze that
// turns waist and head. Nothing jumps: each joint keeps its limits of speed and acceleration.
//
// A plain value; time comes in as an argument.

#include <Eigen/Core>
#include <optional>
#include <set>
#include <string>

#include "musher/modules/world/body/camera_model.hpp"
#include "musher/modules/world/body/trapezoid.hpp"
#include "musher/modules/world/scene/humanoid_specs.hpp"

namespace musher::world {

class Humanoid {
 public:
  explicit Humanoid(HumanoidSpec spec);  // stands in its neutral pose, looking ahead

  // From the next step on. Returns the reason when it refuses an unknown pose.
  std::optional<std::string> SetPose(const std::string& name);
  // x from 0, fully to the left, to 1, fully to the right; y from 0, up, to 1, down. Returns the
  // fault of an invalid point, once for each kind: NaN is refused, other values are clamped.
  std::optional<std::string> LookAt(const Eigen::Vector2d& point);

  void Step(Duration dt);

  const std::string& pose() const { return pose_name_; }
  const std::array<HandShape, kSides>& hands() const { return spec_.poses[pose_].hands; }
  // The angles that the adapter commands, and the joints' angles: they follow a step later.
  const std::array<Axis, kJoints>& commands() const { return commands_; }
  const std::array<Axis, kJoints>& joints() const { return joints_; }
  // Of the head in the body's frame.
  Gaze gaze() const;

 private:
  Angles Goals() const;

  HumanoidSpec spec_;
  std::string pose_name_;
  std::size_t pose_ = 0;  // index into its poses
  Duration held_{};       // how long the pose is held
  Eigen::Vector2d look_{0.5, 0.5};
  std::array<Axis, kJoints> commands_;
  std::array<Axis, kJoints> joints_;
  Axis pitch_;
  std::set<std::string> refused_poses_;  // that were logged
  bool nan_logged_ = false;
  bool outside_logged_ = false;
};

}  // namespace musher::world
