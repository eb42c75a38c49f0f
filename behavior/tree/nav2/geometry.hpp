#pragma once
// Poses, paths and goals of the nodes of nav2, in the frame of the map. Metres, radians; yaw to the
// left is positive. In XML a pose is "x;y;yaw". Plain values; any thread.

#include <cstdint>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/behavior/tree/convert.hpp"

namespace musher::tree::nav2 {

struct Pose {
  double x_m = 0;
  double y_m = 0;
  double z_m = 0;
  double yaw_rad = 0;
  Time stamp{};  // when it was sent: the same place sent again is another goal

  friend bool operator==(const Pose&, const Pose&) = default;
};

struct Path {
  std::vector<Pose> poses;

  friend bool operator==(const Path&, const Path&) = default;
};

// Places to travel through.
struct Goals {
  std::vector<Pose> poses;

  friend bool operator==(const Goals&, const Goals&) = default;
};

// A way through a graph of places: its nodes, and the ids of the edges from each one to the next.
struct Route {
  struct Node {
    std::uint16_t id = 0;
    double x_m = 0;
    double y_m = 0;
    double z_m = 0;

    friend bool operator==(const Node&, const Node&) = default;
  };
  std::vector<Node> nodes;
  std::vector<std::uint16_t> edges;
  double cost = 0;

  friend bool operator==(const Route&, const Route&) = default;
};

// How well a drive keeps to its path.
struct Tracking {
  double off_m = 0;        // to the left of the path; negative: to the right
  double heading_rad = 0;  // to the left of its direction
  double left_m = 0;       // of the path

  friend bool operator==(const Tracking&, const Tracking&) = default;
};

// Without regard to directions and stamps.
double Distance(const Pose& a, const Pose& b);
double LengthOf(const Path& path);

}  // namespace musher::tree::nav2

template <>
struct musher::tree::Convert<musher::tree::nav2::Pose> {
  static constexpr std::string_view kName = "pose, as 'x;y;yaw'";
  static Result<nav2::Pose> FromText(std::string_view text);
};
