#pragma once
// Where a body should be at which time: the fastest motion along a path within its limits, 50
// points a second. Fails, with Fault::kInput, for a path without a pose, with numbers that are not
// finite or longer than kLongestPathM, and for limits that are not positive. A path of one pose, or
// of poses at one place, gives one point. Frame of the map; yaw has no jumps. Pure; any thread.

#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/navigation/trajectory/speed_profile.hpp"

namespace musher::navigation {

inline constexpr Duration kTrajectoryStep = Milliseconds(20);

struct TrajectoryRules {
  MotionLimits limits;
  double corner_m = 0.03;      // how far the motion may leave the path at a corner
  double start_speed_m_s = 0;  // of a body that is already on its way along the path
};

struct TrajectoryPoint {
  Pose pose;
  Velocity velocity;
  Velocity acceleration;
};

// Points a kTrajectoryStep apart; at the last one the body stands.
struct Trajectory {
  std::vector<TrajectoryPoint> points;

  Duration duration() const {
    return points.empty() ? Duration::zero()
                          : kTrajectoryStep * static_cast<std::int64_t>(points.size() - 1);
  }

  // At a time since its begin: before and after it the first and the last point. Not for an empty
  // one.
  TrajectoryPoint At(Duration since_begin) const;
};

Result<Trajectory> MakeTrajectory(const Path& path, const TrajectoryRules& rules);

}  // namespace musher::navigation
