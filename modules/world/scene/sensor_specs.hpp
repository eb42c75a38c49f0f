#pragma once
// The range sensors and the GPS on a simulated body: a part of its scene.

#include <Eigen/Core>
#include <cmath>

namespace musher::world {

// Where a sensor is mounted: from the middle of the trunk, x ahead, y to the left, z upwards. Its
// angles turn it like the body's: yaw to the left, then pitch downwards.
struct Mount {
  Eigen::Vector3d position_m{0, 0, 0};
  double yaw_rad = 0;
  double pitch_rad = 0;
};

// Common to all range sensors: nearer than least_m reads -inf, beyond most_m +inf.
struct Reach {
  double least_m = 0;
  double most_m = 0;
  double noise_m = 0;  // standard deviation
  double rate_hz = 10;
};

// A flat fan of rays, counter-clockwise, both ends included.
struct LidarSpec {
  bool enabled = true;
  Reach reach{0.1, 12, 0.01, 10};
  Mount mount{{0.16, 0, 0.1}, 0, 0};
  double from_rad = -M_PI / 2;
  double to_rad = M_PI / 2;
  int rays = 361;
};

// The nearest thing in a cone.
struct UltrasonicSpec {
  bool enabled = true;
  Reach reach{0.1, 1, 0.005, 10};
  Mount mount{{0.26, 0, 0.02}, 0, -M_PI / 12};  // upwards: its cone misses the ground
  double cone_rad = M_PI / 6;                   // from side to side
};

// The nearest thing in a cone straight down, of a robot.
struct RangeDownSpec {
  Reach reach{0.05, 4, 0.01, 20};
  Eigen::Vector3d position_m{0, 0, 0};  // from the middle of its underside
  double cone_rad = M_PI / 6;           // from side to side
};

// Four of 8 by 8 zones, at the head and at the rear, looking down at what is before the feet.
struct TofSpec {
  bool enabled = true;
  Reach reach{0.05, 0.66, 0.005, 10};
  double view_rad = M_PI / 4;     // from side to side, and from top to bottom
  double ahead_m = 0.24;          // from the middle of the trunk, to either end
  double aside_m = 0.06;          // to either side
  double up_m = 0.03;             // over it
  double outward_rad = M_PI / 9;  // turned to its own side
  double down_rad = M_PI / 6;
};

struct GpsSpec {
  enum class Fix { kNone, kFix, kSbas, kGbas };

  bool enabled = true;
  double latitude_deg = 40.0;  // of the place's (0, 0); its x is east, its y north
  double longitude_deg = 116.3;
  double altitude_m = 45;  // of its ground
  double noise_m = 0.4;    // standard deviation, east and north; twice that in height
  double rate_hz = 1;
  Fix fix = Fix::kFix;
  int satellites = 9;  // in use; none without a fix
};

// A tag carried by a person, measured by the body's ultra-wideband radio.
struct UwbSpec {
  bool enabled = true;
  Eigen::Vector2d tag_m{2, 1};  // where it is in the place
  double most_m = 20;           // beyond it there is no reading
  double noise_m = 0.05;        // standard deviation
  double noise_rad = 0.03;
  double rate_hz = 10;
};

struct SensorSpecs {
  LidarSpec lidar;
  UltrasonicSpec ultrasonic;
  TofSpec tof;
  GpsSpec gps;
  UwbSpec uwb;
};

}  // namespace musher::world
