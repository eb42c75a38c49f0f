#pragma once
// What a simulated place and robot are like: the contents of a scene file as one value. Positions
// are metres in the place's frame, x to the right and y upwards as drawn, yaw counter-clockwise.

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "musher/lifecycle/time.hpp"

namespace musher::world {

struct Pose2 {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0;

  friend bool operator==(const Pose2&, const Pose2&) = default;
};

// A wall is a thin one.
struct Box {
  std::string name;  // written on it; may be empty
  Eigen::Vector2d center_m;
  Eigen::Vector2d half_m;  // half its length and width
  double yaw_rad = 0;
};

struct Circle {
  std::string name;
  Eigen::Vector2d center_m;
  double radius_m = 0;
};

// A square on the ground on which the battery charges.
struct Pad {
  Eigen::Vector2d center_m;
  double size_m = 0;
};

struct BodySpec {
  double radius_m = 0.28;        // of the circle on the ground that nothing else may enter
  double stand_height_m = 0.29;  // of the trunk
  double lie_height_m = 0.08;
  Duration lag = Milliseconds(200);  // time constant with which a commanded speed is taken up
  double slip = 0.03;                // share of the commanded speed that is lost on the ground
  double noise = 0.02;               // standard deviation of the speed, as a share of it
  double odometry_scale = 1.0;       // distance that odometry shows for a metre walked
  double odometry_yaw_drift_rad_per_m = 0;
  Duration command_timeout = std::chrono::seconds(1);  // commands silent so long: it stands still
};

struct BatterySpec {
  double capacity_wh = 150;
  double start_percent = 80;
  double off_w = 5;
  double lying_w = 20;
  double standing_w = 90;
  double moving_w = 220;
  double cable_w = 180;  // what charging puts in
  double pad_w = 90;
};

// A time for a motion in place of the built-in one.
struct MotionTime {
  int mode = 0;
  int gait = 0;
  Duration time{};
};

// What the scene does by itself at a time.
struct ChargeTo {
  double percent = 0;
};
struct Cable {
  bool in = false;
};
struct Touch {
  int state = 0;  // TouchStatus.touch_state
};
struct FaultOn {
  std::string name;  // see Faults()
  int motor = 0;     // 0 to 11, for faults of a motor
};
struct Carry {
  Pose2 at;
};
struct Speed {
  double factor = 1;
};
struct Event {
  Duration at{};
  std::variant<ChargeTo, Cable, Touch, FaultOn, Carry, Speed> what;
};

struct Picture {
  std::string file = "world.png";  // relative: to the machine's state folder, alone to the cwd
  bool at_teardown = false;
};

struct Scene {
  std::string name;
  std::uint64_t seed = 1;
  double speed = 1;  // world time for each second
  Eigen::Vector2d least_m{-5, -4};
  Eigen::Vector2d most_m{5, 4};
  Pose2 start;
  bool start_standing = false;
  BodySpec body;
  BatterySpec battery;
  Picture picture;
  std::vector<Box> boxes;
  std::vector<Circle> circles;
  std::vector<Pad> pads;
  std::vector<MotionTime> motion_times;
  std::vector<Event> events;  // by time
};

inline constexpr double kLeastSpeed = 0.01;
inline constexpr double kMostSpeed = 100;
inline constexpr int kMostTouchState = 0x11;

}  // namespace musher::world
