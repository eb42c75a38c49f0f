#pragma once
// What skills use of their robot: its pose, its velocity command, and the services of other
// processes. `RosRobot` provides it over DDS, a fake one in tests.
//
// Metres, radians, seconds; poses in the frame of the map. Velocity commands are in the frame of
// the body: x forward, y to the left, z up. Requests return futures; see behavior/skill/future.hpp.
//
// Errors of ComputePath() and of drives, by their codes: kCodeStateInvalid, the server rejects the
// request; kCodeNetError, it does not answer or is lost; navigation::Fault::kObstacle, an obstacle
// stays in the way, so that another path may help. Any other one is final.
//
// Threads: the loop of the actuator, where skills are stepped.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/behavior/skill/future.hpp"
#include "musher/navigation/traffic/right_of_way.hpp"

namespace musher::navigation {
struct CellMap;
}  // namespace musher::navigation

namespace musher::skills {

// The map of the ground that a robot's planner has, too.
struct GroundMap {
  bool awaited = false;                              // it may still come
  std::shared_ptr<const navigation::CellMap> cells;  // null: none has come; unknown cells are free
  bool expected = false;                             // the file of the robot names its topic
  std::shared_ptr<const navigation::CellMap> known{};  // the same; unknown cells are not free
};

// As its driver has reported it last.
struct BatteryLevel {
  double share = 0;  // 0 to 1
  std::optional<double> voltage_v{};
  bool charges = false;
};

// A picture as it came: 8 bits a channel, blue, green, red; row by row without gaps.
struct Picture {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> bgr;
};

// An object of the world's ground truth, or one that a detector has seen.
struct SeenObject {
  std::string name;      // "box_red"
  std::string category;  // "box"
  navigation::Pose pose;
  std::string held_by;  // a robot; empty: none
};

// The last look of the robot's detectors at a target.
struct Look {
  Time at;  // when the picture was taken, by Now()
  // Each thing of that name that it shows, in the frame of the body: x forward, y to the left.
  // Empty: it shows none.
  std::vector<navigation::Point> seen;
};

enum class HandAction : std::uint8_t { kCheckDistance, kAttach, kRelease, kPlace };

struct HandRequest {
  HandAction action = HandAction::kCheckDistance;
  std::string object;
  double distance_threshold_m = 2;  // from hand to object; of kCheckDistance and kAttach
  navigation::Point target{};       // of kPlace
};

struct HandReply {
  bool success = false;
  std::string message;     // "Within grasp distance"
  double distance_m = -1;  // from hand to object; negative: not known
};

// A drive along a path that the robot's controller executes. To give it up, Cancel() it, and wait
// until `end` is done. A drive that is destroyed before its end is cancelled.
class Drive {
 public:
  virtual ~Drive() = default;
  virtual std::optional<double> distance_to_goal_m() const = 0;  // nullopt: not reported yet
  virtual void Cancel() = 0;
  // True: arrived. False: cancelled. An error: why it has failed, or was refused; with the code of
  // navigation::Fault::kObstacle where another path may help, kCodeStateInvalid when the controller
  // rejects the path, kCodeNetError when it is lost.
  virtual skill::Future<bool> end() const = 0;
};

// Parts of a robot, for skill::Table::Uses(). Skills that only read, for example what the robot
// detects, use none.
inline constexpr const char* kBase = "base";  // what moves the robot
inline constexpr const char* kArm = "arm";    // with the hand
inline constexpr const char* kCamera = "camera";

class Robot {
 public:
  virtual ~Robot() = default;

  virtual const std::string& name() const = 0;  // "cf2x_0"
  virtual const std::string& kind() const = 0;  // "cf2x"
  virtual bool flies() const = 0;
  virtual double radius_m() const = 0;
  // How high it may fly, above the zero of the map; nullopt: not known. A goal cannot raise it.
  virtual std::optional<double> ceiling_m() const = 0;

  // The time of the present step.
  virtual Time Now() const = 0;
  // Nullopt: no odometry that has a place in the map came within the last 0.5 s.
  virtual std::optional<navigation::Pose> pose() const = 0;
  // Why it has no pose: "No odometry of cf2x_0".
  virtual std::string WhyNoPose() const { return "No odometry of " + name(); }
  virtual navigation::Velocity velocity() const = 0;  // in the frame of the map
  // The same in the frame of its odometry, in which a correction of its localisation moves nothing.
  virtual std::optional<navigation::Pose> odometry() const { return pose(); }
  // The path that it has come on, in that frame, the newest pose first, at most 2 m; see
  // navigation::TravelledPath. Empty: not known, as after a start, or a jump of its odometry.
  virtual navigation::Path travelled() const { return {}; }

  // Sent until the next command, at 20 Hz, as far as the gate before the base lets it pass.
  // StopMotion() sends 0 and then nothing more; a flyer in the air is then held at its place. Both
  // also end at an emergency stop and when skills are paused.
  virtual void SetVelocity(const navigation::Velocity& command) = 0;
  virtual void StopMotion() = 0;
  // What the gate before the base stops the present command for: "an obstacle 0.42 m away, ...";
  // empty: nothing.
  virtual std::string HeldBy() const { return ""; }
  // Why a flyer does not descend as commanded: "something 1.6 m high is 0.42 m below it: ...";
  // empty: it does, or is not commanded down.
  virtual std::string WhyNotDescending() const { return ""; }
  // The height of the ground on which it shall land, in the frame of the map; until StopMotion().
  virtual void ExpectGround(double /*height_m*/) {}
  // A flyer has landed: it is not held at its place any more, until it moves again.
  virtual void NoteLanding() {}
  // Whether its file names a topic by which a person moves it.
  virtual bool HasTeleop() const { return false; }
  // Nullopt: no level that counts has come.
  virtual std::optional<BatteryLevel> battery() const { return std::nullopt; }
  // Whether it is known where the frame `child` lies in `parent`, by /tf and its odometry.
  virtual bool HasTransform(const std::string& /*parent*/, const std::string& /*child*/) const {
    return false;
  }
  // Why a flyer is not held at its place any more: "cf2x_0 is not held at its place any more: it
  // came 0.21 m lower …", as in a hand. Empty: it is held, is moved by a skill or a drive, or has
  // landed.
  virtual std::string WhyNotHeld() const { return {}; }

  // Whether the planner and the controller can be reached now.
  virtual bool HasPlanner() const = 0;
  virtual bool HasController() const = 0;
  // Whether the controller drives the base, for this client or for another one.
  virtual bool Drives() const = 0;
  // Cancels the drives that have begun until now, of every client, also those that a process before
  // this one, which has crashed, has left behind. It is done once the controller can be reached:
  // what it drives for another client then counts as begun before. Drives that begin later go on.
  virtual void CancelEarlierDrives() {}
  // A path from `start`, or from where the robot is. Fails with the planner's reason; with
  // kCodeStateInvalid when the planner rejects the request, kCodeNetError when it is lost.
  virtual skill::Future<navigation::Path> ComputePath(
      const navigation::Pose& goal, const std::optional<navigation::Pose>& start) = 0;
  virtual std::unique_ptr<Drive> FollowPath(const navigation::Path& path) = 0;
  // Planner and controller forget what its scanners have seen earlier. Fails with the reason.
  virtual skill::Future<bool> ClearMemory() { return {}; }

  // What the robot says of itself to others, with what is left of the path of its drive; that of a
  // drive that has just ended still counts.
  virtual navigation::RobotIntent intent() { return {}; }
  // What other robots have said of themselves lately.
  virtual std::vector<navigation::RobotIntent> others() const { return {}; }
  // It finds no place to give way to, or cannot give way: for so long it says so, and others give
  // way to it.
  virtual void NoteCornered(Duration /*time*/) {}
  // A path to the nearest place that is off the paths of the others. Fails with the reason.
  virtual skill::Future<navigation::Path> ComputeRefuge() { return {}; }

  // The first call asks for it.
  virtual GroundMap map() { return {}; }

  // Points that a scan of the last 0.5 s has seen, in the frame of the map. Empty: none, or no
  // scan; see HasScan().
  virtual std::vector<navigation::Point> obstacles() const = 0;
  virtual bool HasScan() const = 0;
  // Whether such a scan covers this place, in the frame of the body: what is there, or before it,
  // is seen. Of a place that is not covered nothing is known.
  virtual bool ScanCovers(const navigation::Point& place) const = 0;

  // Objects by the source of the config, of the last 0.5 s.
  virtual std::vector<SeenObject> objects() const = 0;
  virtual bool HasObjects() const = 0;
  // What the skills that detect see: the objects, or, where the config names detectors of the
  // vision module, what those have seen within the last second. Nullopt: not all have looked yet;
  // the first call asks them to.
  virtual std::optional<std::vector<SeenObject>> Detect() = 0;
  // Why it sees none.
  virtual std::string WhyNothingSeen() const { return "no objects were received"; }
  // The last look at a thing with this name or of this category, by what its detectors have found
  // in their pictures, and not by a map. Nullopt: no picture of the last second; the first call
  // asks for them.
  virtual std::optional<Look> LookFor(const std::string& /*target*/) { return std::nullopt; }
  // Why there is no look: "no detections on jetbot_0/detections".
  virtual std::string WhyNoLook() const { return name() + " has no detector"; }
  // The pose that came on `topic` (nav_msgs/Odometry) within the last 0.5 s and has a place in the
  // map; the first call subscribes. Nullopt: none.
  virtual std::optional<navigation::Pose> PoseOf(const std::string& topic) = 0;
  // Why there is none: "no pose on /target_0/odom".
  virtual std::string WhyNoPoseOf(const std::string& topic) const { return "no pose on " + topic; }
  // How many have come on it since it was subscribed to.
  virtual std::uint64_t PosesOf(const std::string& topic) const = 0;

  virtual bool HasCamera(const std::string& camera) const = 0;
  virtual std::vector<std::string> cameras() const = 0;
  // The next picture of that camera.
  virtual skill::Future<Picture> TakePicture(const std::string& camera) = 0;
  // The file is written by another thread. Fails with the reason.
  virtual skill::Future<std::string> SavePng(const Picture& picture, const std::string& path) = 0;
  // The lateral offset (m, left positive) and heading (rad) of the line that the robot follows, of
  // the last 0.5 s. Nullopt: it is not seen.
  struct Line {
    double offset_m = 0;
    double heading_rad = 0;
  };
  virtual std::optional<Line> line() const = 0;

  virtual bool HasHand() const = 0;
  virtual skill::Future<HandReply> UseHand(const HandRequest& request) = 0;
};

}  // namespace musher::skills
