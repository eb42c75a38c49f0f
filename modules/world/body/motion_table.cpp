#include "musher/modules/world/body/motion_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace musher::world {
namespace {

using Eigen::Vector3d;

const Vector3d kNowhere{0, 0, 0};
const Vector3d kSlow{0.65, 0.30, 1.25};
const Vector3d kMedium{1.00, 0.30, 1.25};
const Vector3d kFast{1.60, 0.55, 2.50};
const Vector3d kPronk{0.25, 0.10, 0.50};
const Vector3d kBound{0.40, 0.30, 0.75};

constexpr Duration kIntoGait = Milliseconds(300);
constexpr double kQuarter = M_PI / 2;
constexpr double kWhole = 2 * M_PI;

Motion Walk(int mode, int gait, const Vector3d& limit) {
  return {mode, gait, Kind::kWalk, kIntoGait, limit, kNowhere, 0, 0, 0};
}
Motion Leap(int gait, int ms, const Vector3d& leads, double height_m) {
  return {16, gait, Kind::kLeap, Milliseconds(ms), kNowhere, leads, height_m, 0, 0};
}
Motion Flip(int gait, int ms, const Vector3d& leads, double pitch_rad, double roll_rad) {
  return {17, gait, Kind::kLeap, Milliseconds(ms), kNowhere, leads, 0.35, pitch_rad, roll_rad};
}
Motion Plain(int mode, int gait, Kind kind, int ms, double pitch_rad = 0) {
  return {mode, gait, kind, Milliseconds(ms), kNowhere, kNowhere, 0, pitch_rad, 0};
}

// Of one mode, entries with a gait of their own come first.
const std::array kMotions = {
    Plain(kModeOff, kAnyGait, Kind::kOff, 500),
    Plain(kModeLie, 0, Kind::kLie, 1000),
    Plain(kModeLie, kAnyGait, Kind::kLie, 2000),
    Plain(kModeStand, 17, Kind::kStand, 6000),
    Plain(kModeStand, 18, Kind::kStand, 6000),
    Plain(kModeStand, kAnyGait, Kind::kStand, 2000),
    Plain(3, kAnyGait, Kind::kPose, 300),
    Plain(21, kAnyGait, Kind::kPose, 300),
    Walk(11, 2, kPronk),
    Walk(11, 7, kBound),
    Walk(11, 3, kMedium),
    Walk(11, 10, kFast),
    Walk(11, kAnyGait, kSlow),
    Walk(9, kAnyGait, kSlow),
    Walk(6, kAnyGait, kSlow),
    Walk(25, kAnyGait, kSlow),
    Walk(81, kAnyGait, kSlow),
    Walk(82, kAnyGait, kSlow),
    Leap(0, 1200, {0, 0, kQuarter}, 0.12),
    Leap(3, 1200, {0, 0, -kQuarter}, 0.12),
    Leap(1, 1800, {0.60, 0, 0}, 0.18),
    Leap(4, 1200, {0.30, 0, 0}, 0.14),
    Leap(2, 1200, {0, 0.20, 0}, 0.12),
    Leap(5, 1200, {0, -0.20, 0}, 0.12),
    Leap(6, 1200, {0, 0, 0}, 0.30),
    Leap(9, 2000, {0.30, 0, 0}, 0.10),
    Leap(16, 800, {0, 0, 0}, 0.10),
    Leap(kAnyGait, 3000, {0, 0, 0}, 0.15),
    Plain(23, kAnyGait, Kind::kLeap, 2500),
    Flip(0, 3000, {0.4, 0, 0}, kWhole, 0),
    Flip(1, 3000, {-0.4, 0, 0}, -kWhole, 0),
    Flip(10, 1500, {0, 0, 0}, -kWhole, 0),
    Flip(kAnyGait, 1500, {0, 0, 0}, 0, kWhole),
    Plain(62, 0, Kind::kShow, 30000),
    Plain(62, kAnyGait, Kind::kShow, 8000),
    Plain(64, kAnyGait, Kind::kShow, 4000, -1.2),
    Plain(5, kAnyGait, Kind::kShow, 5000),
    Plain(65, kAnyGait, Kind::kShow, 5000),
    Plain(80, kAnyGait, Kind::kShow, 3000),
    Plain(86, kAnyGait, Kind::kShow, 5000),
};

struct Successors {
  int mode;
  int gait;
  std::vector<int> next;
};
// As in the robot's motion table; of one mode, entries with a gait of their own come first. From
// standing every mode may follow.
const std::array<Successors, 24> kSuccessors = {{
    {0, kAnyGait, {0, 12, 7, 15}},
    {7, kAnyGait, {0, 12, 7, 80}},
    {3, kAnyGait, {0, 7, 12, 11, 21, 3}},
    {5, kAnyGait, {21, 12, 7, 3, 0, 17, 16, 5}},
    {6, kAnyGait, {0, 12, 7, 21, 3, 11, 6}},
    {9, kAnyGait, {0, 12, 7, 3, 11}},
    {11, kAnyGait, {0, 12, 7, 21, 3, 6, 11, 23, 80, 81, 82}},
    {16, 16, {0, 12, 7, 21, 6, 11, 62, 5, 64, 16, 17, 23, 9, 80, 82, 81}},
    {16, kAnyGait, {0, 12, 7, 21}},
    {17, 8, {0, 7, 12, 21, 5, 17}},
    {17, 10, {0, 7, 12, 21, 5, 17}},
    {17, 11, {0, 7, 12, 21, 5, 17}},
    {17, 12, {0, 7, 12, 21, 5, 17}},
    {17, kAnyGait, {0, 7, 12, 21}},
    {21, kAnyGait, {0, 12, 7, 21, 5, 64, 62}},
    {23, kAnyGait, {0, 12, 7, 3}},
    {25, kAnyGait, {0, 12, 7, 21, 3, 11, 6, 25}},
    {62, kAnyGait, {0, 12, 7, 21}},
    {64, kAnyGait, {0, 12, 7, 16}},
    {65, kAnyGait, {0, 3, 16, 6, 21, 11, 12, 80, 7}},
    {80, kAnyGait, {0, 12, 7, 11, 80, 81, 82}},
    {81, kAnyGait, {0, 12, 7, 11, 80, 81, 82}},
    {82, kAnyGait, {0, 12, 7, 11, 80, 81, 82}},
    {86, kAnyGait, {0, 7, 12, 80}},
}};

const char* NameOfKind(Kind kind) {
  switch (kind) {
    case Kind::kOff:
      return "off";
    case Kind::kLie:
      return "lie";
    case Kind::kStand:
      return "stand";
    case Kind::kWalk:
      return "walk";
    case Kind::kPose:
      return "pose";
    case Kind::kLeap:
      return "jump";
    case Kind::kShow:
      return "show";
  }
  return "";
}

}  // namespace

const Motion* FindMotion(int mode, int gait) {
  const auto* const found =
      std::find_if(kMotions.begin(), kMotions.end(), [&](const Motion& motion) {
        return motion.mode == mode && (motion.gait == gait || motion.gait == kAnyGait);
      });
  return found == kMotions.end() ? nullptr : &*found;
}

bool MayFollow(int mode, int gait, int next) {
  if (mode == kModeStand) return true;
  const auto* const row =
      std::find_if(kSuccessors.begin(), kSuccessors.end(), [&](const Successors& following) {
        return following.mode == mode && (following.gait == gait || following.gait == kAnyGait);
      });
  return row != kSuccessors.end() &&
         std::find(row->next.begin(), row->next.end(), next) != row->next.end();
}

const char* NameOf(int mode, int gait) {
  if (mode == 17) return "flip";
  if (mode == 62) return "dance";
  const Motion* motion = FindMotion(mode, gait);
  return motion == nullptr ? "?" : NameOfKind(motion->kind);
}

}  // namespace musher::world
