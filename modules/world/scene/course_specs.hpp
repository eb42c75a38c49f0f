#pragma once
// What makes a scene a course: zones that a referee watches, the order in which the robot has to
// reach them, and what differs from run to run. Positions are metres in the place's frame, angles
// are radians, counter-clockwise. Plain values without threads and errors.

#include <Eigen/Core>
#include <string>
#include <vector>

namespace musher::world {

// A rectangle on the ground. It is reached when the middle of the body comes into it, or, of a zone
// to lie in, when the body lies in it completely.
struct Zone {
  std::string name;
  Eigen::Vector2d center_m{0, 0};
  Eigen::Vector2d half_m{0.5, 0.5};  // half its length and width
  double yaw_rad = 0;
  bool lie = false;
};

// The measures of the body that the referee uses. The feet are discs.
struct RefereeSpec {
  std::vector<std::string> order;  // names of zones; one may occur again
  double stance_length_m = 0.40;   // between the middles of a fore foot and a hind foot
  double stance_width_m = 0.30;    // between the middles of a left foot and a right one
  double foot_m = 0.04;            // diameter
  double body_length_m = 0.56;
  double body_width_m = 0.34;
};

// The largest deviation of each value, to either side; 0: none.
struct Variation {
  double start_m = 0;  // of each coordinate of the start
  double start_rad = 0;
  double board_rad = 0;   // of each board's yaw
  double brightness = 0;  // as a share
  double temperature_k = 0;
  double slip = 0;
  double yaw_slip = 0;
  double odometry_scale = 0;
  double odometry_yaw_drift_rad_per_m = 0;
  double camera_noise = 0;
};

// What the seed, or the caller, selected for this run.
struct Sampled {
  std::string name;
  std::string value;
};

}  // namespace musher::world
