#pragma once
// Places, poses and velocities of the navigation chain, all in the frame of the map. Metres,
// radians, seconds; yaw to the left is positive. Plain values; any thread.

#include <cmath>
#include <vector>

namespace musher::navigation {

struct Point {
  double x_m = 0;
  double y_m = 0;
  double z_m = 0;

  friend bool operator==(const Point&, const Point&) = default;
};

struct Pose {
  Point at;
  double yaw_rad = 0;

  friend bool operator==(const Pose&, const Pose&) = default;
};

// Also used for accelerations, then in m/s² and rad/s².
struct Velocity {
  double x_m_s = 0;
  double y_m_s = 0;
  double z_m_s = 0;
  double yaw_rad_s = 0;

  friend bool operator==(const Velocity&, const Velocity&) = default;
};

using Path = std::vector<Pose>;

inline double Distance(const Point& a, const Point& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m, a.z_m - b.z_m);
}

inline double Speed(const Velocity& velocity) {
  return std::hypot(velocity.x_m_s, velocity.y_m_s, velocity.z_m_s);
}

// The same direction within [-pi, pi].
inline double Wrapped(double angle_rad) {
  return std::remainder(angle_rad, 2 * M_PI);
}

inline Point Between(const Point& a, const Point& b, double share) {
  return {a.x_m + share * (b.x_m - a.x_m), a.y_m + share * (b.y_m - a.y_m),
          a.z_m + share * (b.z_m - a.z_m)};
}

inline bool IsFinite(const Point& point) {
  return std::isfinite(point.x_m) && std::isfinite(point.y_m) && std::isfinite(point.z_m);
}

inline bool IsFinite(const Pose& pose) {
  return IsFinite(pose.at) && std::isfinite(pose.yaw_rad);
}

// The velocity that a body with this yaw executes: x forward, y to the left.
inline Velocity InBodyFrame(const Velocity& velocity, double yaw_rad) {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  return {c * velocity.x_m_s + s * velocity.y_m_s, c * velocity.y_m_s - s * velocity.x_m_s,
          velocity.z_m_s, velocity.yaw_rad_s};
}

// Points in the frame of a body, in the frame in which its pose is.
inline std::vector<Point> PlacedAt(const Pose& body, const std::vector<Point>& points) {
  const double c = std::cos(body.yaw_rad), s = std::sin(body.yaw_rad);
  std::vector<Point> placed;
  placed.reserve(points.size());
  for (const Point& point : points) {
    placed.push_back({body.at.x_m + c * point.x_m - s * point.y_m,
                      body.at.y_m + s * point.x_m + c * point.y_m, body.at.z_m + point.z_m});
  }
  return placed;
}

// A pose in the frame of a body, in the frame in which its pose is.
inline Pose PlacedAt(const Pose& body, const Pose& pose) {
  return {PlacedAt(body, std::vector<Point>{pose.at})[0], Wrapped(body.yaw_rad + pose.yaw_rad)};
}

}  // namespace musher::navigation
