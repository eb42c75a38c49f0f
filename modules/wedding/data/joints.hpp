#pragma once
// The robot's 24 joints, in the order of its messages, and where its head looks.

#include <array>
#include <cstddef>
#include <string_view>

namespace musher::wedding {

inline constexpr std::size_t kJointCount = 24;
inline constexpr std::array<std::string_view, kJointCount> kJointNames = {
    "j00_hip_pitch_l",    "j01_hip_roll_l",       "j02_hip_yaw_l",        "j03_knee_pitch_l",
    "j04_ankle_pitch_l",  "j05_ankle_roll_l",     "j06_hip_pitch_r",      "j07_hip_roll_r",
    "j08_hip_yaw_r",      "j09_knee_pitch_r",     "j10_ankle_pitch_r",    "j11_ankle_roll_r",
    "j12_waist_yaw",      "j13_shoulder_pitch_l", "j14_shoulder_roll_l",  "j15_shoulder_yaw_l",
    "j16_elbow_pitch_l",  "j17_elbow_yaw_l",      "j18_shoulder_pitch_r", "j19_shoulder_roll_r",
    "j20_shoulder_yaw_r", "j21_elbow_pitch_r",    "j22_elbow_yaw_r",      "j23_head_yaw"};
inline constexpr std::size_t kWaistYaw = 12;
inline constexpr std::size_t kHeadYaw = 23;

using JointAngles = std::array<double, kJointCount>;  // rad

// Of the head in space; left is positive.
constexpr double LookYaw(const JointAngles& joints) {
  return joints[kWaistYaw] + joints[kHeadYaw];
}

}  // namespace musher::wedding
