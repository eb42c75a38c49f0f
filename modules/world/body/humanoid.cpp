#include "musher/modules/world/body/humanoid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace musher::world {
namespace {

using Eigen::Vector2d;

const MotionLimits& LimitsOf(const HumanoidSpec& spec, JointGroup group) {
  return spec.limits[static_cast<std::size_t>(group)];
}

std::string Shortened(const std::string& name) {
  constexpr std::size_t kLongest = 60;
  return name.size() <= kLongest ? name : name.substr(0, kLongest) + "...";
}

}  // namespace

const std::array<Joint, kJoints>& JointTable() {
  using enum JointGroup;
  static constexpr std::array<Joint, kJoints> kTable = {{
      {"j00_hip_pitch_l", kLeg, -1.8, 0.8},      {"j01_hip_roll_l", kLeg, -0.3, 0.6},
      {"j02_hip_yaw_l", kLeg, -1.0, 1.0},        {"j03_knee_pitch_l", kLeg, 0.0, 2.3},
      {"j04_ankle_pitch_l", kLeg, -0.9, 0.7},    {"j05_ankle_roll_l", kLeg, -0.4, 0.4},
      {"j06_hip_pitch_r", kLeg, -1.8, 0.8},      {"j07_hip_roll_r", kLeg, -0.6, 0.3},
      {"j08_hip_yaw_r", kLeg, -1.0, 1.0},        {"j09_knee_pitch_r", kLeg, 0.0, 2.3},
      {"j10_ankle_pitch_r", kLeg, -0.9, 0.7},    {"j11_ankle_roll_r", kLeg, -0.4, 0.4},
      {"j12_waist_yaw", kWaist, -2.6, 2.6},      {"j13_shoulder_pitch_l", kArm, -2.9, 1.2},
      {"j14_shoulder_roll_l", kArm, -0.4, 2.6},  {"j15_shoulder_yaw_l", kArm, -2.0, 2.0},
      {"j16_elbow_pitch_l", kArm, -2.3, 0.1},    {"j17_elbow_yaw_l", kArm, -2.0, 2.0},
      {"j18_shoulder_pitch_r", kArm, -2.9, 1.2}, {"j19_shoulder_roll_r", kArm, -2.6, 0.4},
      {"j20_shoulder_yaw_r", kArm, -2.0, 2.0},   {"j21_elbow_pitch_r", kArm, -2.3, 0.1},
      {"j22_elbow_yaw_r", kArm, -2.0, 2.0},      {"j23_head_yaw", kHead, -1.57, 1.57},
  }};
  return kTable;
}

Humanoid::Humanoid(HumanoidSpec spec) : spec_(std::move(spec)) {
  static_cast<void>(SetPose(std::string(kNeutralPose)));
  const Angles goals = Goals();
  for (std::size_t i = 0; i < kJoints; ++i) commands_[i] = {goals[i], 0};
  joints_ = commands_;
}

std::optional<std::string> Humanoid::SetPose(const std::string& name) {
  std::vector<std::string_view> known;
  for (std::size_t i = 0; i < spec_.poses.size(); ++i) {
    const std::vector<std::string>& names = spec_.poses[i].names;
    known.insert(known.end(), names.begin(), names.end());
    if (std::find(names.begin(), names.end(), name) == names.end()) continue;
    if (pose_name_ == name) return std::nullopt;
    pose_name_ = name;
    pose_ = i;
    held_ = {};
    return std::nullopt;
  }
  constexpr std::size_t kMostLogged = 16;
  if (refused_poses_.size() == kMostLogged) return std::nullopt;
  if (!refused_poses_.insert(Shortened(name)).second) return std::nullopt;
  std::string reason = "the pose \"" + Shortened(name) + "\" is refused: it is none of";
  for (const std::string_view one : known) reason.append(" ").append(one);
  if (refused_poses_.size() == kMostLogged) reason += "; further ones are not logged";
  return reason;
}

std::optional<std::string> Humanoid::LookAt(const Vector2d& point) {
  if (!point.allFinite()) {
    if (std::exchange(nan_logged_, true)) return std::nullopt;
    return "a point to look at that is no number is refused; further ones are not logged";
  }
  look_ = point.cwiseMax(0).cwiseMin(1);
  if (look_ == point || std::exchange(outside_logged_, true)) return std::nullopt;
  return "a point to look at is outside 0 to 1 and is brought within; further ones are not logged";
}

void Humanoid::Step(Duration dt) {
  const double seconds = ToSeconds(dt);
  held_ += dt;
  joints_ = commands_;
  const Angles goals = Goals();
  for (std::size_t i = 0; i < kJoints; ++i) {
    const MotionLimits& limits = LimitsOf(spec_, JointTable()[i].group);
    commands_[i] = Approach(commands_[i], goals[i], limits, seconds);
  }
  const double pitch = 2 * (look_.y() - 0.5) * spec_.pitch_rad;
  pitch_ = Approach(pitch_, pitch, LimitsOf(spec_, JointGroup::kHead), seconds);
}

Angles Humanoid::Goals() const {
  const PoseSpec& pose = spec_.poses[pose_];
  Angles goals = pose.angles;
  const double held_s = ToSeconds(held_);
  for (const Swing& swing : pose.swings) {
    goals[swing.joint] += swing.amplitude_rad * std::sin(2 * M_PI * held_s / swing.period_s);
  }
  const double left = -2 * (look_.x() - 0.5);
  goals[kWaistYaw] = left * spec_.waist_yaw_rad;
  goals[kHeadYaw] = left * spec_.head_yaw_rad;
  return goals;
}

Gaze Humanoid::gaze() const {
  return {joints_[kWaistYaw].position_rad + joints_[kHeadYaw].position_rad, pitch_.position_rad};
}

}  // namespace musher::world
