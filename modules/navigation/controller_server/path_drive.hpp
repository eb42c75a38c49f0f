#pragma once
// Drives one robot along paths: makes the trajectory, follows it, and says how the drive has ended.
// Pure: odometry, scans and the time are arguments.
//
//   standing ──Start()──▶ driving ──▶ standing, with an end
//                          │   ▲
//     Start() of another   ▼   │
//     path in motion      braking on the present path, until it stands
//
// A body that moves in the direction of the new path goes on without braking.
//
// - What its scans have seen lately is remembered (navigation/grid). Points that the map has are
//   left out, as long as the path fits the map: they do not slow the body down. Those that are on
//   its way stop it.
// - The velocity is in the frame of the body. A differential body gets none aside: its distance
//   from the path turns it. One that comes to rest beside its path, or its goal, because its
//   localisation was corrected or it was pushed, goes on from there by a new trajectory along the
//   rest of the path, a few times.
// - From one command to the next the velocity changes no more than the limits say, unless it brakes
//   for an obstacle, the gate slows it down, or the drive ends. A body with a known lag is driven
//   with a part of its accelerations: the command leads it, and so changes more.
// - Where the body is now: the last odometry, with its velocity since then.
// - Every command goes through the gate, which knows only what the scanners see; a drive that it
//   has stopped for `obstacle_time` ends. The guard ends one whose odometry cannot be true.
// - Without odometry or a scan (if the robot has one) for their times the drive ends. Messages with
//   the stamp of one before count for neither.
//
// Metres, radians, the frame of the map. One thread.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/nav2_msgs/follow_path.hpp"
#include "musher/modules/navigation/controller_server/controller_config.hpp"
#include "musher/modules/navigation/messages/conversions.hpp"
#include "musher/navigation/controller/command_limit.hpp"
#include "musher/navigation/controller/follower.hpp"
#include "musher/navigation/controller/progress_check.hpp"
#include "musher/navigation/gate/motion_guard.hpp"
#include "musher/navigation/grid/local_grid.hpp"
#include "musher/navigation/planner/clearance.hpp"
#include "musher/navigation/pose_history.hpp"

namespace musher::navigation {

using FollowCode = msg::FollowPath;

// How a drive has ended.
struct DriveEnd {
  std::uint16_t error_code = 0;  // of nav2_msgs/FollowPath; NONE: arrived
  std::string reason;            // why not
};

class PathDrive {
 public:
  PathDrive(const ControllerRobot& robot, const ControllerConfig& config);

  // Null: none is known. In the middle of a drive, the rest of its path has to fit the new map as
  // well for its points to be left out.
  void SetMap(std::shared_ptr<const Clearance> map, Time now);
  // Cells into which no drive leads; null: none. A drive that leads there ends.
  void SetKeepOut(std::shared_ptr<const CellMap> keep_out);
  // When a drive has arrived, and what progress it has to make; before Start(). Where that replaces
  // a drive that has to make the same, the time goes on.
  void Check(double arrive_m, double arrive_rad, const std::optional<ProgressRules>& progress);
  // `stamp`: of the message, since the zero of its clock.
  void OnOdometry(const Motion& motion, Duration stamp, Time now);
  // `scanner`: its index in the config.
  void OnScan(std::size_t scanner, const Scan& scan, Duration stamp, Time now);
  // Of the sensor that looks down.
  void OnRange(const DownReading& reading, Duration stamp, Time now) {
    gate_.OnRange(reading, stamp, now);
  }
  bool BlindBelow(Time now) const { return gate_.BlindBelow(now); }
  // Where the scanner is on the body, by a transform.
  void Mount(std::size_t scanner, const FramePlacement& placement) {
    gate_.Mount(scanner, placement.pose, placement.upside_down);
  }
  // No faster than that, also in later drives; infinite: as fast as its own limit.
  void LimitSpeed(double speed_m_s) { follower_.LimitSpeed(speed_m_s); }
  // What was seen and is not seen any more does not count; the gate knows only the last scans.
  void ClearMemory();
  // Odometry and scans of before are not used.
  void Forget();

  // Drives along `path`, also in the middle of another one. An end: why not; then the body has to
  // stand.
  std::optional<DriveEnd> Start(const Path& path, Time now);
  // The body has to stand at once.
  void Stop();

  struct Step {
    Velocity command;             // in the frame of the body
    bool begins = false;          // with a new trajectory()
    std::optional<DriveEnd> end;  // then the command is 0
    std::string held;             // what the gate slows it down for; empty: it does not
    double distance_m = 0;        // to the goal, along the path
    double speed_m_s = 0;         // of the body
  };
  Step Update(Time now);

  bool driving() const { return driving_; }
  // By the last odometry; nullopt: there was none.
  std::optional<Pose> pose() const { return motion_ ? std::optional(motion_->pose) : std::nullopt; }
  const Trajectory& trajectory() const { return follower_.trajectory(); }

  // Why the robot cannot drive now; nothing if it can.
  std::optional<DriveEnd> Blind(Time now) const;

 private:
  std::optional<DriveEnd> Begin(const Path& path, double start_speed_m_s, Time now);
  bool Fits(const Path& path, double radius_m) const;
  // The first place of a path in the cells to keep out of; a body that is in them may leave.
  std::optional<Point> EntersKeepOut(const Path& path) const;
  Path PathAhead() const;
  // Whether it has come to rest off its path: it can turn to it and go there. `waits`: the
  // reference does.
  bool RestsOffItsPath(bool waits, const Command& command, const Step& step, Time now);
  void CompareWithMap(Time now);
  double AlignedSpeed(const Path& joined) const;
  Pose PoseNow(Time now) const;
  std::optional<DriveEnd> Gate(const Command& command, const Pose& pose, Time now, Step& step);
  static DriveEnd Failure(const Error& error);
  Velocity BodyCommand(const Velocity& velocity, double yaw_rad) const;
  double DistanceLeft(Duration reference) const;

  const ControllerRobot robot_;
  const ControllerConfig config_;
  Follower follower_;
  std::shared_ptr<const Clearance> map_;
  bool leaves_out_map_ = false;  // points that the map has do not count
  bool driving_ = false;
  bool begins_ = false;       // the trajectory has not been reported yet
  std::optional<Path> next_;  // while it brakes
  std::optional<Time> rests_since_;
  int joined_again_ = 0;           // times since Start()
  std::vector<double> lengths_m_;  // of the trajectory up to each point
  std::optional<Motion> motion_;
  Time motion_at_;
  bool odometry_refused_ = false;  // the last one
  PoseHistory poses_;
  LocalGrid seen_;                            // lately
  std::vector<std::optional<Time>> seen_at_;  // by each scanner
  std::vector<Point> obstacles_;              // those of seen_ that count
  Duration reference_{};                      // on the trajectory
  CommandLimit limit_;
  MotionGate gate_;
  MotionGuard guard_;
  std::optional<Error> fault_;  // found by the guard, or a new keep-out
  std::shared_ptr<const CellMap> keep_out_;
  ProgressCheck progress_;
};

}  // namespace musher::navigation
