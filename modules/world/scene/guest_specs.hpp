#pragma once
// Guests of a scene and their acts, as read from its file.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/modules/world/scene/color.hpp"

namespace musher::world {

// By the words of wedding/perception/gesture.
enum class Gesture { kNone, kHeart, kV, kOk };
inline constexpr std::array<std::string_view, 4> kGestureNames{"none", "heart", "v", "ok"};

// Where a guest looks: at the robot's camera, away from it, where it goes, or in a direction.
struct GuestLook {
  enum class At { kRobot, kAway, kAhead, kYaw };
  At at = At::kAhead;
  double yaw_rad = 0;  // with kYaw
};

// The act of a guest at a time; what is not given continues as before.
struct GuestAct {
  Duration at{};
  std::optional<Eigen::Vector2d> walk_to_m;
  std::optional<double> speed_m_s;
  std::optional<GuestLook> look;
  std::optional<Gesture> gesture;
  bool leave = false;  // leaves at walk_to_m, else where it came from
};

struct GuestSpec {
  std::string name;
  Eigen::Vector2d from_m{0, 0};  // where it appears, and leaves to
  double yaw_rad = 0;
  int face = 0;
  double height_m = 1.7;
  double speed_m_s = 0.8;
  Color color{70, 82, 110};  // of its clothes
  bool gown = false;
  std::vector<GuestAct> acts;  // by time; the guest is absent before the first one
};

inline constexpr double kGuestRadiusM = 0.2;  // on the ground

}  // namespace musher::world
