#pragma once
// The robot of the skills for the nodes of nav2 in a behaviour tree: its planner, its controller,
// and its recoveries with the amounts that the tree gives. So nav2's trees run on it:
//
//   skills::TreeRobot nav2(robot);
//   tree::nav2::AddNodes(factory, nav2);
//
// BackUp, DriveOnHeading and Spin are those of recovery.hpp: they fail without odometry, without a
// scan that covers their way, and where the gate holds the robot; they turn with 0.6 rad/s and move
// with 0.15 m/s at most. ClearEntireCostmap clears what planner and controller remember, whichever
// costmap it names. Names of planners and controllers are ignored: the robot has one of each.
//
// One task has the base at a time, also where the tree runs two of them. A motion begins once the
// controller drives no more, for any client, no other motion runs and the robot stands; a drive
// once no motion runs and the robot stands. What waits fails at its limit, a drive after 10 s. A
// motion fails where another client begins a drive. A drive replaces a drive without a stop. Paths
// and arrivals are checked as those of travel.hpp. Where the same run of a tree follows the same
// path again, and the robot is within 1 m of where that drive has ended, what it has passed of the
// path is left out: at its end nothing is left, unless the path is a loop.
//
// The drives that the controller has begun before the constructor are cancelled once it can be
// reached: a process before this one has left them behind.
//
// NavigateToPose and NavigateThroughPoses travel as the skill navigate_to does, FollowObject as
// track: with their recoveries, and their defaults. AssistedTeleop leaves the base to the person at
// the topic `teleop` of its file. The battery is the one of its file, whichever topic a tree names.
// Whether a place is occupied is known by the map of the ground, and by what the scan sees now.
//
// Frames and units of robot.hpp.
//
// Threads: the loop of the actuator.

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/behavior/tree/nav2/robot.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

// The base between two tasks.
class Handover {
 public:
  explicit Handover(Robot& robot) : robot_(robot) {}

  // A drive that is cancelled here; it goes on until its end.
  void GiveUp(std::unique_ptr<Drive> drive);
  // Whether such a one still goes on, or the controller drives for any client.
  bool IsDriven();
  // The base is that of this motion until it is released. False: another motion has it.
  bool Take(const tree::nav2::Task& motion);
  void Release(const tree::nav2::Task& motion);
  void NoteMotion() {
    moved_ = true;
    arrived_at_.reset();
  }
  // Whether a motion has the base, or has ended and the robot does not stand yet.
  bool Rolls();
  bool HasMotion() const { return motion_ != nullptr; }
  // Without odometry it is taken to stand: a motion does not begin then.
  bool Stands() const;
  // Whether drives have waited for the base for 10 s, also where each has replaced the one before.
  // Called as long as one waits.
  bool HasWaited(Time now);
  void EndWait() { waits_since_.reset(); }

  // A drive along `path` has begun, or has ended.
  void NoteBegin(navigation::Path path);
  void NoteEnd(const navigation::Path& path);
  // Whether the last drive was along `path`, and the robot is where it has ended.
  bool GoesOn(const navigation::Path& path) const;
  // Whether that drive has arrived, nothing has moved the robot since, and `rest` is all that is
  // left of the path: nothing. A loop has no such end.
  bool IsAtEndOf(const navigation::Path& path, const navigation::Path& rest) const;
  void Forget() { NoteBegin({}); }

  // A path for `goal` was planned, which ends at `end`.
  void NotePlan(const navigation::Pose& goal, const navigation::Pose& end);
  // The last drive has arrived at the end of its path, and nothing has moved the robot since.
  void NoteArrival(const navigation::Pose& end) { arrived_at_ = end; }
  // How far from `goal` that drive may have arrived; nullopt: it has not arrived, or at another
  // goal.
  std::optional<double> ArrivedWithin(const navigation::Pose& goal) const;

 private:
  struct Plan {
    navigation::Pose goal;
    navigation::Pose end;
  };

  Robot& robot_;
  std::vector<std::unique_ptr<Drive>> given_up_;
  const tree::nav2::Task* motion_ = nullptr;  // that has the base
  bool moved_ = false;
  std::optional<Time> waits_since_;  // drives
  Time asked_at_{};                  // HasWaited()
  navigation::Path last_path_;       // of the last drive
  std::optional<navigation::Pose> ended_at_;
  std::deque<Plan> plans_;  // the last ones
  std::optional<navigation::Pose> arrived_at_;
};

class TreeRobot : public tree::nav2::Robot {
 public:
  // The robot must outlive it; it must outlive the trees.
  explicit TreeRobot(skills::Robot& robot) : robot_(robot), handover_(robot) {
    robot_.CancelEarlierDrives();
  }

  // The goal that has come last on the topic of GoalUpdater, if the program subscribes to it.
  // Nullopt: none.
  void SetGoalUpdate(const std::optional<tree::nav2::Pose>& goal) { goal_update_ = goal; }
  // A call of a service of PauseResumeController, if the program serves it.
  void NoteCall(const std::string& service) { ++calls_[service]; }

  std::optional<tree::nav2::Pose> pose() const override;
  double speed_m_s() const override;  // forward, in the frame of the body
  std::optional<tree::nav2::Motion> motion() const override;
  bool IsDriven() const override { return handover_.HasMotion() || robot_.Drives(); }
  std::optional<tree::nav2::Battery> battery(std::string_view topic) const override;
  bool HasTransform(std::string_view parent, std::string_view child) const override;
  std::uint64_t Calls(std::string_view service) const override;
  bool flies() const override { return robot_.flies(); }
  // 0.25 m; where the last drive has arrived at this goal, as far from it as it may have.
  double goal_tolerance_m(const tree::nav2::Pose& goal) const override;
  bool selects_controllers() const override { return false; }
  double most_turn_rad_s() const override;
  double most_drive_m_s() const override;
  std::optional<tree::nav2::Pose> goal_update() const override { return goal_update_; }
  // By what its scan sees now: no point so near to the rest of the path that the controller would
  // stop before it.
  bool IsFree(const tree::nav2::Path& path) const override;
  // Also where both lead from the robot to the same end within 0.2 m: a plan from just behind its
  // goal would turn it round.
  bool IsSameDrive(const tree::nav2::Path& driven, const tree::nav2::Path& next) const override;
  bool CancelDrives() override;
  void OnNewRun() override { handover_.Forget(); }

  std::unique_ptr<tree::nav2::Task> ComputePath(const tree::nav2::Pose& goal,
                                                const std::optional<tree::nav2::Pose>& start,
                                                const std::string& planner) override;
  std::unique_ptr<tree::nav2::Task> FollowPath(const tree::nav2::Path& path,
                                               const std::string& controller) override;
  std::unique_ptr<tree::nav2::Task> Spin(double angle_rad, Duration limit) override;
  std::unique_ptr<tree::nav2::Task> Drive(double distance_m, double speed_m_s,
                                          Duration limit) override;
  std::unique_ptr<tree::nav2::Task> ClearCostmap(const std::string& service) override;
  std::unique_ptr<tree::nav2::Task> CheckPlaces(
      const tree::nav2::OccupancyRequest& request) override;
  std::unique_ptr<tree::nav2::Task> Navigate(const tree::nav2::Goals& places) override;
  std::unique_ptr<tree::nav2::Task> FollowObject(const std::string& topic, Duration limit) override;
  std::unique_ptr<tree::nav2::Task> Teleoperate(Duration limit) override;

 private:
  skills::Robot& robot_;
  Handover handover_;
  std::optional<tree::nav2::Pose> goal_update_;
  std::map<std::string, std::uint64_t, std::less<>> calls_;  // of services
};

}  // namespace musher::skills
