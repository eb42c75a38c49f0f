#pragma once
// The actions by which clients of nav2 send a robot to places: NavigateToPose, NavigateThroughPoses
// and FollowWaypoints. Each pose is a run of the robot's skill for that (navigate_to), one after
// the other; so its limits, its recoveries, a pause and the gate are those of the skill.
//
// A pose on the topic goal_pose, as RViz's button for a goal publishes it, counts as a goal of
// NavigateToPose; its end, or why it is refused, is logged. It has no height: a flyer goes there at
// its present one.
//
//   a newer goal of any of them replaces the present one, which is aborted
//   a goal that is refused, also for its height, leaves the present one
//   no pose is gone to once no skill may start, for example with a low battery: the goal is aborted
//   a goal while the base is used by another skill, or while no skills run, is aborted at once
//   NavigateThroughPoses ends at the first pose that it does not reach; FollowWaypoints goes on,
//   and its result lists what it has missed: then it is aborted
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/log.hpp"
#include "musher/behavior/skill/manager.hpp"
#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/modules/skills/config/skills_config.hpp"
#include "musher/modules/skills/robot/robot.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::skills {

class Nav2Goals {
 public:
  // What it uses; must outlive it.
  struct Context {
    Robot& robot;
    skill::Manager& manager;
    std::function<Result<>()> may_start;  // why no skill may be started now
    std::function<void(LogLevel level, const std::string& line)> log;
  };

  // The skill of `names` that sends a robot to a place; empty: it has none.
  static std::string SkillFor(const std::vector<std::string>& names);

  // Serves the actions that the config names, as long as the endpoints; must be destroyed before.
  Nav2Goals(Context context, const InterfaceNames& names, transport::Endpoints& endpoints);
  // The present goal is aborted.
  ~Nav2Goals();
  Nav2Goals(const Nav2Goals&) = delete;
  Nav2Goals& operator=(const Nav2Goals&) = delete;

  // After each step of the skills, and after their cancellation: the end of a run leads to the next
  // pose or to the end of the goal.
  void Update();

 private:
  class Mission;
  template <class Action>
  class MissionOf;
  class TopicMission;

  template <class Action>
  void Serve(const std::string& name, transport::Endpoints& endpoints);
  template <class Action>
  void Start(transport::ServerGoal<Action> goal);
  void OnGoalPose(const msg::PoseStamped& goal);
  Result<> MayBegin(const std::vector<navigation::Pose>& places) const;
  // Of the present goal, by a newer one.
  void Replace();
  Result<> Drive();
  void OnEndOfRun(const skill::Run& run);
  void End(bool success, const std::string& why);

  const Context context_;
  const std::string skill_;
  const transport::Node& node_;
  transport::Clock& clock_;
  const std::string goal_pose_;       // the topic
  std::unique_ptr<Mission> mission_;  // null: there is no goal
};

}  // namespace musher::skills
