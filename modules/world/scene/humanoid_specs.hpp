#pragma once
// A humanoid's joints, their limits and its poses, as read from a scene.

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace musher::world {

enum class JointGroup { kLeg, kWaist, kArm, kHead };

// Angles are rad: yaw is to the left; a pitch lifts forwards where it is negative, and bends knees
// where it is positive; a roll lifts to the left.
struct Joint {
  std::string_view name;
  JointGroup group = JointGroup::kLeg;
  double least_rad = 0;
  double most_rad = 0;
};

inline constexpr std::size_t kJoints = 24;
inline constexpr std::size_t kWaistYaw = 12;
inline constexpr std::size_t kHeadYaw = 23;
const std::array<Joint, kJoints>& JointTable();  // in the order of their messages

using Angles = std::array<double, kJoints>;  // rad

// The limits of a joint's motion.
struct MotionLimits {
  double speed_rad_s = 0;
  double acceleration_rad_s2 = 0;
};

// A joint that swings as long as the pose is held.
struct Swing {
  std::size_t joint = 0;
  double amplitude_rad = 0;
  double period_s = 1;
};

// The shape of a hand in a pose: only visible, no joint moves it.
enum class HandShape { kOpen, kCurled, kFist, kV, kThumb };
inline constexpr std::size_t kSides = 2;  // left, right

struct PoseSpec {
  std::vector<std::string> names;
  Angles angles{};
  std::vector<Swing> swings;
  std::array<HandShape, kSides> hands{};
};

inline constexpr std::string_view kNeutralPose = "neutral";

struct HumanoidSpec {
  // By JointGroup.
  std::array<MotionLimits, 4> limits = {{{0.5, 1.0}, {0.3, 0.8}, {0.3, 0.5}, {0.5, 1.0}}};
  // How far a gaze of 0 or 1 turns them from straight ahead.
  double head_yaw_rad = 70 * M_PI / 180;
  double waist_yaw_rad = 50 * M_PI / 180;
  double pitch_rad = 20 * M_PI / 180;  // the camera's mount; 0: it has none
  std::string poses_file;              // absolute; empty: neutral only
  std::vector<PoseSpec> poses = {{{std::string(kNeutralPose)}, {}, {}, {}}};
  std::string pose_topic = "wedding/motion/pose";
  std::string look_at_topic = "wedding/motion/look_at";
  std::string joint_states_topic = "wedding/motion/joint_states";
  std::string joint_commands_topic = "wedding/motion/joint_commands";
};

}  // namespace musher::world
