#pragma once
// A simulated place and robot: the contents of a scene file as one value. Positions are metres in
// the place's frame, x to the right and y upwards as drawn, yaw counter-clockwise.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/modules/world/scene/battery_spec.hpp"
#include "musher/modules/world/scene/camera_specs.hpp"
#include "musher/modules/world/scene/color.hpp"
#include "musher/modules/world/scene/course_specs.hpp"
#include "musher/modules/world/scene/field_specs.hpp"
#include "musher/modules/world/scene/guest_specs.hpp"
#include "musher/modules/world/scene/humanoid_specs.hpp"
#include "musher/modules/world/scene/robot_specs.hpp"
#include "musher/modules/world/scene/sensor_specs.hpp"

namespace musher::world {

struct Pose2 {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0;

  friend bool operator==(const Pose2&, const Pose2&) = default;
};

inline constexpr double kThingHeightM = 0.5;
inline constexpr Color kThingColor{196, 188, 174};

// A wall is a thin one. It stands on the ground, or hangs over it as a barrier does.
struct Box {
  std::string name;  // written on it in the picture; may be empty
  Eigen::Vector2d center_m;
  Eigen::Vector2d half_m;  // half its length and width
  double yaw_rad = 0;
  double height_m = kThingHeightM;  // from its lower side to its upper one
  double bottom_m = 0;              // of its lower side over the ground
  Color color = kThingColor;
};

// An upright cylinder.
struct Circle {
  std::string name;
  Eigen::Vector2d center_m;
  double radius_m = 0;
  double height_m = kThingHeightM;
  double bottom_m = 0;
  Color color = kThingColor;
};

// One with a name can appear and disappear; it casts no shadow.
struct Ball {
  Eigen::Vector3d center_m;
  double radius_m = 0.1;
  Color color = kThingColor;
  bool glows = false;  // a lamp: light and shadow do not change its colour
  std::string name = {};
  bool shown = true;         // now; else it is not there
  double show_within_m = 0;  // it appears once when the robot is as near as this; 0: never
  Duration show_for{};       // and disappears after this time
};

// The front of a board.
struct Sign {
  enum class Kind { kPlain, kPicture, kQr, kText, kFace, kArrow };
  Kind kind = Kind::kPlain;
  std::string content;  // the file (absolute), the code's text, the text, or left, right
  int face = 0;         // which one
  Color ink{24, 24, 26};
};

// An upright rectangle, or the ellipse in it, without thickness; its front faces the direction of
// its yaw.
struct Board {
  std::string name;
  Eigen::Vector2d center_m;
  double yaw_rad = 0;
  double width_m = 0.3;
  double height_m = 0.3;
  double bottom_m = 0.2;  // of its lower edge over the ground
  Color color{244, 244, 242};
  Sign sign = {};
  bool round = false;
};

// Painted on the ground, from point to point.
struct Line {
  std::vector<Eigen::Vector2d> points_m;  // the first one again at the end of a closed one
  double width_m = 0.05;
  Color color{246, 206, 20};
  bool watched = false;  // the referee reports every foot on it
};

// A word on the ground, for the picture only.
struct GroundLabel {
  std::string text;
  Eigen::Vector2d middle_m;
};

// A square on the ground on which the battery charges.
struct Pad {
  Eigen::Vector2d center_m;
  double size_m = 0;
};

struct Ground {
  enum class Texture { kPlain, kChecker, kGrass, kPicture };
  Texture texture = Texture::kPlain;
  Color color{150, 152, 140};
  Color other_color{128, 130, 120};  // the other squares of a checker, the blades of grass
  double finest_per_m = 320;         // texels in a metre, if the place is not too large for it
  double tile_m = 1;                 // a square of a checker, a picture that is laid side by side
  std::string file;                  // of a picture, absolute
  bool once = false;  // the picture is laid out once, from least_m to most_m, else side by side
  Eigen::Vector2d least_m{0, 0};
  Eigen::Vector2d most_m{1, 1};
};

// One far light, and what comes from the sky on every side.
struct Lighting {
  double brightness = 1;
  double temperature_k = 6500;  // of its colour: lower is redder, higher is bluer
  double yaw_rad = 0.6;         // of the direction the light comes from
  double height_rad = 0.9;      // of the light over the horizon
  double ambient = 0.5;         // share of the light that comes from everywhere
  double gradient = 0;  // share of the light that is missing at the darkest end of the place
  double gradient_yaw_rad = 0;  // towards which it gets darker
  bool shadows = true;          // on the ground
  Color sky{150, 186, 222};
};

inline constexpr std::size_t kCameras = 3;
inline constexpr std::array<std::string_view, kCameras> kCameraNames{"front", "left", "right"};

struct CameraSet {
  // What happens to a picture that is due while the last one is still being drawn.
  enum class Late { kSkip, kWait };
  Late late = Late::kSkip;
  std::array<CameraSpec, kCameras> cameras;

  CameraSet();  // like CyberDog's: one ahead, and a fisheye on either side
};

struct BodySpec {
  double radius_m = 0.28;        // of the circle on the ground that nothing else may enter
  double stand_height_m = 0.29;  // of the trunk
  double lie_height_m = 0.08;
  Duration lag = Milliseconds(200);  // time constant with which a commanded speed is taken up
  double slip = 0.03;                // share of the commanded speed lost to slip
  std::optional<double> yaw_slip;    // the same of the commanded yaw rate; none: as slip
  double noise = 0.02;               // standard deviation of the speed, as a share of it
  double odometry_scale = 1.0;       // distance that odometry shows for a metre walked
  double odometry_yaw_drift_rad_per_m = 0;
  Duration command_timeout = std::chrono::seconds(1);  // timeout without a command: it stands still
};

// Replaces the built-in time of a motion.
struct MotionTime {
  int mode = 0;
  int gait = 0;
  Duration time{};
};

// Events that the scene triggers at a time.
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
  std::string name;  // see Faults() and kSensorFaults
  int motor = 0;     // 0 to 11, for faults of a motor
};
struct Carry {
  Pose2 at;
};
struct Speed {
  double factor = 1;
};
struct Show {
  std::string name;   // of a ball
  bool shown = true;  // false: it disappears
};
struct SceneEvent {
  Duration at{};
  std::variant<ChargeTo, Cable, Touch, FaultOn, Carry, Speed, Show> what;
};

struct Picture {
  std::string file = "world.png";  // relative: to the machine's state folder, alone to the cwd
  bool at_teardown = false;
  bool scan = false;  // what the lidar sees, as dots
  // What the colour of the body's path shows: the machine's state, or the battery where there is no
  // machine; or the time.
  enum class Way { kState, kTime };
  Way way = Way::kState;
};

// How the body's motion board is reached, beside world/body_state.
struct BoardSpec {
  bool lcm = false;  // false: by world/body_command; true: on LCM, as that of a CyberDog 2
  std::string command_url = "udpm://239.255.76.67:7671";
  std::string response_url = "udpm://239.255.76.67:7670";
  std::string localization_url = "udpm://239.255.76.67:7667";
  std::string network_interface;  // empty: that of the route
  int ttl = 0;                    // 0: on this computer only
};

struct Scene {
  std::string name;
  std::uint64_t seed = 1;
  double speed = 1;        // world time for each second
  bool lockstep = false;   // a step waits until all processes that use /clock have had the last one
  bool localised = false;  // map → odom of the body on /tf, where it really is
  Eigen::Vector2d least_m{-5, -4};
  Eigen::Vector2d most_m{5, 4};
  double ceiling_m = 0;  // over the ground; 0: there is none
  bool has_body = true;  // else `start`, `body`, `battery`, `cameras` and `sensors` are not used
  Pose2 start;
  bool start_standing = false;
  BodySpec body;
  BoardSpec motion_board;
  BatterySpec battery;
  Picture picture;
  std::vector<Box> boxes;
  std::vector<Circle> circles;
  std::vector<Ball> balls;
  std::vector<Board> boards;
  std::vector<Line> lines;
  std::vector<Pad> pads;
  std::vector<GroundLabel> labels;
  std::vector<MotionTime> motion_times;
  std::vector<SceneEvent> events;  // by time
  double fence_height_m = 0.6;     // around the place; 0: there is none to be seen
  Color fence_color{176, 138, 96};
  Ground ground;
  Lighting light;
  CameraSet cameras;
  std::optional<HumanoidSpec> humanoid;  // else it has no joints and no head
  std::vector<GuestSpec> guests;
  Duration guests_repeat{};  // period of the timetables; zero: no repetition
  std::string gesture_topic = "wedding/perception/gesture";
  SensorSpecs sensors;
  std::vector<RobotSpec> robots;
  std::vector<ObjectSpec> objects;
  std::vector<MoverSpec> movers;
  std::optional<FieldSpec> field;
  std::vector<Zone> zones;
  RefereeSpec referee;
  std::vector<Sampled> sampled;  // choices first
};

// The fault of a sensor: it is silent. "none" ends these, too.
inline constexpr std::string_view kSensorFaults[] = {
    "camera front",  "camera left",    "camera right",  "lidar",          "ultrasonic", "tof",
    "tof_left_head", "tof_right_head", "tof_left_rear", "tof_right_rear", "gps",        "uwb"};
// Of the hardware on a field: FIELD.md has what each does.
inline constexpr std::string_view kFieldFaults[] = {
    "arm silent",       "arm stuck",      "spear silent", "spear stuck", "suspension silent",
    "suspension stuck", "distances lost", "pose silent",  "base stuck",  "r1 silent"};

inline constexpr double kLeastSpeed = 0.01;
inline constexpr double kMostSpeed = 100;
inline constexpr int kMostTouchState = 0x11;

}  // namespace musher::world
