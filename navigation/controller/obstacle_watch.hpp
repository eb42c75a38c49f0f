#pragma once
// Whether something stands in the way that a body is about to go. Pure; any thread. Metres,
// radians, seconds, the frame of the map.

#include <optional>
#include <vector>

#include "musher/navigation/trajectory/trajectory.hpp"

namespace musher::navigation {

struct ObstacleRules {
  double radius_m = 0.3;       // of the body
  double margin_m = 0.1;       // between the body and an obstacle, at least
  double side_s = 0.4;         // more room for a moving body: what it drives in this time
  double pass_m_s = 0.2;       // but so fast it passes anything that the margin lets it pass
  double brake_m_s2 = 0.8;     // with which the body stops
  double hardest_m_s2 = 2.0;   // the same for an obstacle that appears nearer than that
  double reaction_s = 0.1;     // from the scan to the begin of braking
  double clear_ahead_m = 0.5;  // a body that stands starts only if so much of its path is clear
  double more_ahead_m = 0.3;   // and so much more after it has waited
};

// A planar scan, as in sensor_msgs/LaserScan: ranges outside the limits and those that are not
// finite are no points.
struct Scan {
  double from_rad = 0;
  double step_rad = 0;
  double least_m = 0;
  double most_m = 0;
  std::vector<float> ranges_m;
};

// `sensor`: where the scan was taken.
std::vector<Point> PointsOf(const Scan& scan, const Pose& sensor);

// The length of the path to a stop.
double BrakingDistance(double speed_m_s, const ObstacleRules& rules);

struct Obstruction {
  Point at;            // of the obstacle
  double ahead_m = 0;  // how far the body can go until it touches the margin
};

// The first obstacle that the body would come too near to on its next `ahead_m` of the trajectory,
// from `since_begin` on. Obstacles that are already near do not hold a body that moves away. Height
// counts only in three dimensions: for `flat`, points are compared by x and y.
std::optional<Obstruction> FirstObstruction(const Trajectory& trajectory, Duration since_begin,
                                            double ahead_m, const std::vector<Point>& obstacles,
                                            bool flat, const ObstacleRules& rules);

}  // namespace musher::navigation
