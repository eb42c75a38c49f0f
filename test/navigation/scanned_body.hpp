#pragma once
// A round body on a map, with a scanner: it executes velocities with a lag and limited
// accelerations, as a real one. Deterministic; simulated time.

#include <random>

#include "musher/navigation/controller/obstacle_watch.hpp"
#include "musher/navigation/planner/clearance.hpp"

namespace musher::navigation::testing {

struct ScannedBodyOptions {
  double radius_m = 0.2;
  double lag_s = 0.1;  // of its velocity behind the command
  double acceleration_m_s2 = 2.5;
  double range_m = 6;
  int rays = 360;
  double noise_m = 0.005;  // of a range, at most
};

class ScannedBody {
 public:
  // `walls` must outlive it.
  ScannedBody(const Clearance& walls, const Pose& start, const ScannedBodyOptions& options)
      : walls_(walls), options_(options), pose_(start) {}

  const Pose& pose() const { return pose_; }
  const Velocity& velocity() const { return velocity_; }  // in the frame of the body

  void Move(const Velocity& command, double seconds);
  Scan Look(std::mt19937_64& random) const;
  // From its edge to the nearest wall.
  double room_m() const { return walls_.At(pose_.at, 1 + options_.radius_m) - options_.radius_m; }
  double ToWall(double angle_rad) const;

 private:
  const Clearance& walls_;
  const ScannedBodyOptions options_;
  Pose pose_;
  Velocity wanted_;  // behind the lag
  Velocity velocity_;
};

// The map within a wall.
CellMap Fenced(CellMap map);

}  // namespace musher::navigation::testing
