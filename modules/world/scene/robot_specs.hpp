#pragma once
// The robots of a scene that are driven by velocity, the objects that their hands can hold, and
// the movers that go about between them. Metres, seconds and radians; positions are in the place's
// frame, z upwards from the ground. Plain values without threads and errors.

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/modules/world/scene/battery_spec.hpp"
#include "musher/modules/world/scene/camera_specs.hpp"
#include "musher/modules/world/scene/color.hpp"
#include "musher/modules/world/scene/sensor_specs.hpp"

namespace musher::world {

// How a robot moves. One that is differential never moves aside.
enum class RobotKind { kDifferential, kHolonomic, kFlyer };

// The limits of a robot's motion, to either side.
struct RobotLimits {
  double speed_m_s = 1.5;  // over the ground
  double acceleration_m_s2 = 2.5;
  double turn_rad_s = 1.5;
  double turn_acceleration_rad_s2 = 4;
  double climb_m_s = 1;  // of a flyer, up and down
};

// Gusts push a flyer off its place with a velocity that changes all the time.
struct WindSpec {
  double drift_m_s = 0;  // standard deviation along each axis of the ground; 0: no wind
  double gust_s = 2;     // how long a gust lasts
};

// What a robot grasps with: one object at a time. Its position is from the middle of the robot's
// underside, x ahead, y to the left, z upwards.
struct HandSpec {
  Eigen::Vector3d position_m{0.35, 0, 0.4};
  double reach_m = 1;  // from the hand to the middle of an object
};

// A camera that looks down: the part of the ground in which it sees the lines of the scene.
struct LineViewSpec {
  double ahead_m = 0.2;  // from the middle of the robot to its lower edge
  double width_m = 0.8;  // from its left to its right edge
  double depth_m = 0.6;  // from its lower to its upper edge
};

// A detector of objects in the pictures of a camera that looks ahead; the eye is that of the
// robot's camera, or the middle of its upper side.
struct DetectorSpec {
  double most_m = 4;                  // farther away it finds nothing
  double hfov_rad = M_PI * 70 / 180;  // from side to side
  double rate_hz = 10;
  double noise_m = 0.01;  // standard deviation along each axis
  double miss_share = 0;  // of the pictures in which it misses an object
};

struct RobotSpec {
  std::string name;  // the namespace of its topics
  RobotKind kind = RobotKind::kHolonomic;
  Eigen::Vector3d start_m{0, 0, 0};  // the middle of its underside
  double start_yaw_rad = 0;
  double radius_m = 0.2;  // of an upright cylinder that nothing else may enter
  double height_m = 0.3;
  Color color{40, 96, 170};
  RobotLimits limits;
  WindSpec wind;
  Duration command_timeout = Milliseconds(500);  // without a command it stops, or hovers
  bool stamped_command = false;                  // it is a TwistStamped
  BatterySpec battery;                           // standing_w on the ground, moving_w else
  std::optional<HandSpec> hand;
  std::optional<CameraSpec> camera;
  std::optional<LineViewSpec> line_view;
  std::optional<DetectorSpec> detector;
  std::optional<RangeDownSpec> range_down;
  // A full circle, over the middle of its underside.
  LidarSpec lidar{true, {0.05, 10, 0.01, 10}, {{0, 0, 0.15}, 0, 0}, -M_PI, M_PI * 179 / 180, 360};
};

// What a hand can hold.
struct ObjectSpec {
  std::string name;
  std::string category;
  Eigen::Vector3d middle_m{0, 0, 0};
  double yaw_rad = 0;
  Eigen::Vector3d size_m{0.15, 0.15, 0.15};  // length, width and height
  bool round = false;                        // an upright cylinder: its length is its diameter
  Color color{200, 60, 50};
};

// An upright cylinder that goes from point to point by itself, and waits for robots in its way.
struct MoverSpec {
  std::string name;
  std::vector<Eigen::Vector2d> points_m;
  bool round_trip = false;  // from the last point to the first one, else back the same way
  double radius_m = 0.2;
  double height_m = 1.5;
  double speed_m_s = 0.5;
  double speed_vary = 0.2;  // share by which the seed varies its speed from point to point
  double wait_s = 0;        // longest time at a point; the seed selects it
  Color color{150, 90, 170};
  bool tracked = false;  // its odometry is published
};

inline constexpr double kHighestFlightM = 100;  // without a ceiling

}  // namespace musher::world
