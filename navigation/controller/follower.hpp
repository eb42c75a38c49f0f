#pragma once
// Drives a body along a trajectory, made for 60 updates a second. Pure: time, pose, velocity and
// obstacles are arguments.
//
//   idle ──Start()──▶ following ◀──▶ waiting        an obstacle is in the way, or has left it
//                        │              │
//                        ▼              ▼
//                     arrived         failed        late, or an obstacle stays
//
// - The reference moves along the trajectory. For an obstacle on the next braking distance it slows
//   down with `brake_m_s2`, or harder for one that appears nearer, so the body stops on its way,
//   without leaving it. It is slow beside an obstacle, as a moving body keeps more room, but not
//   slower than `pass_m_s`: it passes, or it waits. An obstacle that comes nearer by itself, by two
//   sets of obstacles after each other, counts as so much nearer that the body stands when they
//   meet. The reference also waits for a body that is more than `lead_m` away from it.
// - Each axis is controlled with a receding horizon (axis_control.hpp); the command is limited to
//   the highest speed in space.
// - Arrived: the reference is at the end and the body within `arrive_m` and `arrive_rad` of it.
//   Failed: `late` after the trajectory's time without arrival, without what obstacles cost;
//   or an obstacle in the way for `give_up` in one go, or obstacles cost more than `most_slowed`
//   and twice the trajectory's time in all. In both the velocity is 0 and stays so. An obstacle
//   costs time as long as it is there, and until the body has its speed again. So every drive ends.
//   A limit of the speed makes the trajectory's time longer.
// - `replan` of the command: the obstacle has been in the way for `replan_after`. A new
//   trajectory, by Start(), may come at any time. Where something is in its way from its begin on,
//   the time goes on: else a body whose plans differ would wait for ever.
//
// A pose that is not finite gives velocity 0 and is no progress. Frame of the map. One thread.

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "musher/navigation/controller/axis_control.hpp"
#include "musher/navigation/controller/obstacle_watch.hpp"

namespace musher::navigation {

struct FollowerRules {
  MotionLimits limits;  // of the command: speed and yaw rate; speeding up again after a stop
  double step_s = 1.0 / 60;
  double lag_s = 0;  // of the body behind the command, 0 if not known
  double place_weight = 10;
  double yaw_weight = 1;
  double velocity_weight = 0.5;
  double yaw_rate_weight = 0.1;
  bool flat = true;  // a body on the ground: no command for z
  double arrive_m = 0.2;
  double arrive_rad = 0.1;
  double lead_m = 0.5;
  Duration late = std::chrono::seconds(5);
  ObstacleRules obstacles;
  Duration replan_after = std::chrono::seconds(2);
  Duration give_up = std::chrono::seconds(30);
  Duration most_slowed = std::chrono::seconds(90);
};

enum class Progress { kIdle, kFollowing, kWaiting, kArrived, kFailed };

struct Command {
  Velocity velocity;  // in the frame of the map
  Progress progress = Progress::kIdle;
  bool replan = false;
  std::optional<Obstruction> obstruction;
  std::optional<Error> failure;  // why it has failed
  Duration reference{};          // the place on the trajectory, as its time
};

class Follower {
 public:
  explicit Follower(const FollowerRules& rules);

  // Also in the middle of another trajectory. Fails for one without a point.
  Result<> Start(Trajectory trajectory, Time now);

  // Idle, velocity 0.
  void Stop();

  // Brakes on its way, within the limits, until Start() or Stop().
  void Halt() { halting_ = true; }
  // After Halt(): the reference stands.
  bool Halted() const { return halting_ && pace_ == 0; }

  // No faster than that from now on, also in later trajectories; it brakes within the limits.
  void LimitSpeed(double speed_m_s) { speed_limit_m_s_ = speed_m_s; }

  // When it has arrived, from now on.
  void ArriveWithin(double arrive_m, double arrive_rad) {
    rules_.arrive_m = arrive_m;
    rules_.arrive_rad = arrive_rad;
  }

  // Something else than its own obstacles slows the body down, for example a gate.
  void NoteSlowed(Time now);

  // `velocity` of the body in the frame of the map. `obstacles`: points that the trajectory's map
  // does not have.
  Command Update(Time now, const Pose& pose, const Velocity& velocity,
                 const std::vector<Point>& obstacles);

  const Trajectory& trajectory() const { return trajectory_; }
  Progress progress() const { return progress_; }

 private:
  Velocity Control(const Pose& pose, const Velocity& velocity);
  void MoveReference(Time now, double dt_s, const Pose& pose, const Velocity& velocity,
                     const std::vector<Point>& obstacles);
  // The highest pace by the limit of the speed.
  double HighestPace(double planned_m_s) const;
  double SideRoom(double speed_m_s) const;
  double Braking(double speed_m_s, const std::optional<Obstruction>& passed) const;
  void WatchApproach(Time now, const Pose& pose, const Velocity& velocity,
                     const std::vector<Point>& obstacles);
  bool HasArrived(const Pose& pose, const Velocity& velocity) const;
  void CountTime(Time now, Duration passed, Duration moved, const Pose& pose);
  void Fail(Error error);

  FollowerRules rules_;
  std::array<AxisControl, 4> axes_;
  Trajectory trajectory_;
  Progress progress_ = Progress::kIdle;
  Time last_{};
  Duration reference_{};  // on the trajectory
  Duration driven_{};     // since Start(), without waiting
  Duration waiting_{};    // in one go
  Duration slowed_{};     // what obstacles have cost since Start()
  std::optional<Time> slowed_until_;
  bool halting_ = false;
  double pace_ = 0;         // 1: the reference moves as the trajectory says
  double pace_change_ = 0;  // a second
  double highest_pace_ = 1;
  double speed_limit_m_s_ = std::numeric_limits<double>::infinity();
  std::optional<Obstruction> obstruction_;
  std::optional<Error> failure_;
  std::vector<Point> seen_;  // the last set of obstacles
  Time seen_at_{};
  double approach_m_s_ = 0;  // of the nearest one ahead, by its own motion
};

}  // namespace musher::navigation
