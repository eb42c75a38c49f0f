#pragma once
// The motions of a CyberDog-like body's board, by mode and gait: how long they take, where they
// lead, and which modes may follow. Times are those of a calm robot, well within the limits of the
// robot's motion table.

#include <Eigen/Core>
#include <span>

#include "musher/base/time.hpp"

namespace musher::world {

enum class Kind {
  kOff,    // damps and sinks down
  kLie,    // lies down
  kStand,  // stands up, from anywhere
  kWalk,   // continues as long as commands come, or for their duration
  kPose,   // takes up the commanded attitude
  kLeap,   // jumps and flips: once begun they end on the ground
  kShow,   // dances and the like, on the spot
};

struct Motion {
  int mode = 0;
  int gait = 0;  // kAnyGait: all that are not listed
  Kind kind = Kind::kShow;
  Duration time{};                 // to its end; for kWalk until it is in its gait
  Eigen::Vector3d limit{0, 0, 0};  // kWalk: speed x and y in m/s, yaw in rad/s
  Eigen::Vector3d leads{0, 0, 0};  // kLeap: x and y in m, yaw in rad, relative to its start
  double height_m = 0;             // kLeap: how high it gets
  double pitch_rad = 0;            // kLeap: how far it turns over; kShow: how it stands
  double roll_rad = 0;
};

inline constexpr int kAnyGait = -1;

inline constexpr int kModeOff = 0;
inline constexpr int kModeLie = 7;
inline constexpr int kModeStand = 12;

// Null: an unknown mode.
const Motion* FindMotion(int mode, int gait);

// Whether the mode `next` may follow that mode and gait.
bool MayFollow(int mode, int gait, int next);

// A name for messages: "trot", "lie down".
const char* NameOf(int mode, int gait);

}  // namespace musher::world
