#pragma once
// The lines that a camera of the walker shows, as points on the ground. Pure. Frames and units of
// mounted_camera.hpp. Any thread.

#include <vector>

#include "musher/messages/musher_msgs/yellow_lines.hpp"
#include "musher/navigation/camera/mounted_camera.hpp"

namespace musher::line_walker {

using navigation::GroundPoint;
using navigation::OnGround;
using navigation::ShareOf;

inline constexpr double kDegree = 0.017453292519943295;  // in radians

using GroundPoints = std::vector<GroundPoint>;

// Its detector searches lines from `region_top` downwards, a share of the picture's height.
struct MountedCamera : navigation::MountedCamera {
  double region_top = 0;

  friend bool operator==(const MountedCamera&, const MountedCamera&) = default;
};

// The edge of a message, at most `most` points of it, evenly chosen; others are left out.
GroundPoints EdgeOnGround(const MountedCamera& camera, double trunk_height_m, double farthest_m,
                          const msg::YellowLines& lines, std::size_t most);

}  // namespace musher::line_walker
