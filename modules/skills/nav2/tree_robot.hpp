#pragma once
// The robot of the skills for the nodes of nav2 in a behaviour tree: its planner, its controller,
// and its recoveries with the amounts that the tree gives. So nav2's trees run on it:
//
//   skills::TreeRobot nav2(robot);
//   tree::nav2::AddNodes(factory, nav2);
//
// BackUp, DriveOnHeading and Spin are those of recovery.hpp: they fail without odometry, without a
// scan that covers their way, and where the gate holds the robot. ClearEntireCostmap clears what
// planner and controller remember, whichever costmap it names. Names of planners and controllers
// are ignored: the robot has one of each.
//
// Frames and units of robot.hpp.
//
// Threads: the loop of the actuator.

#include "musher/behavior/tree/nav2/robot.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

class TreeRobot : public tree::nav2::Robot {
 public:
  // The robot must outlive it, and the trees.
  explicit TreeRobot(skills::Robot& robot) : robot_(robot) {}

  // Goals that have come on the topics of GoalUpdater, if the program subscribes to them.
  void SetGoalUpdate(const tree::nav2::Pose& goal) { goal_update_ = goal; }

  std::optional<tree::nav2::Pose> pose() const override;
  double speed_m_s() const override;  // forward, in the frame of the body
  std::optional<tree::nav2::Pose> goal_update() const override { return goal_update_; }

  std::unique_ptr<tree::nav2::Task> ComputePath(const tree::nav2::Pose& goal,
                                                const std::optional<tree::nav2::Pose>& start,
                                                const std::string& planner) override;
  std::unique_ptr<tree::nav2::Task> FollowPath(const tree::nav2::Path& path,
                                               const std::string& controller) override;
  std::unique_ptr<tree::nav2::Task> Spin(double angle_rad, Duration limit) override;
  std::unique_ptr<tree::nav2::Task> Drive(double distance_m, double speed_m_s,
                                          Duration limit) override;
  std::unique_ptr<tree::nav2::Task> ClearCostmap(const std::string& service) override;

 private:
  skills::Robot& robot_;
  std::optional<tree::nav2::Pose> goal_update_;
};

}  // namespace musher::skills
