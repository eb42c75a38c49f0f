// Which nodes nav2's own trees use, with which ports and values: read from the files of
// nav2_bt_navigator and from its documentation, not from our models. Each is checked, and can be
// ticked.

#include <map>
#include <set>
#include <sstream>

#include "musher/test/behavior/tree/nav2/fake_robot.hpp"

namespace musher::tree::nav2::own_trees_test {

// A node a line: its name, then port=value; a value without braces is a fixed text. A control or a
// decorator is followed by nothing: it is checked around a child of its own.
struct OwnTree {
  std::string name;
  std::string uses;
};

const std::string kSelectors =
    "ControllerSelector selected_controller={controller} default_controller=FollowPath "
    "topic_name=controller_selector\n"
    "PlannerSelector selected_planner={planner} default_planner=GridBased "
    "topic_name=planner_selector\n";
const std::string kMoreSelectors =
    "ProgressCheckerSelector selected_progress_checker={progress} "
    "default_progress_checker=progress_checker topic_name=progress_checker_selector\n"
    "GoalCheckerSelector selected_goal_checker={checker} default_goal_checker=general_goal_checker "
    "topic_name=goal_checker_selector\n"
    "PathHandlerSelector selected_path_handler={handler} default_path_handler=PathHandler "
    "topic_name=path_handler_selector\n";
const std::string kPlan =
    "ComputePathToPose goal={goal} path={path} planner_id={planner} error_code_id={plan_code} "
    "error_msg={plan_error}\n";
const std::string kFollow =
    "FollowPath path={path} controller_id={controller} error_code_id={follow_code} "
    "error_msg={follow_error}\n";
const std::string kFollowWithFeedback =
    "FollowPath path={path} controller_id={controller} goal_checker_id={checker} "
    "progress_checker_id={progress} path_handler_id={handler} error_code_id={follow_code} "
    "error_msg={follow_error} tracking_feedback={feedback}\n";
const std::string kWhereHelpful =
    "WouldAControllerRecoveryHelp error_code={follow_code}\n"
    "WouldAPlannerRecoveryHelp error_code={plan_code}\n";
const std::string kClear =
    "ClearEntireCostmap service_name=global_costmap/clear_entirely_global_costmap\n"
    "ClearEntireCostmap service_name=local_costmap/clear_entirely_local_costmap\n";
const std::string kRecover =
    "RecoveryNode number_of_retries=6\nRecoveryNode number_of_retries=1\nPipelineSequence\n"
    "ReactiveFallback\nGoalUpdated\nRoundRobin\nSequence\n" +
    kClear +
    "Wait wait_duration=5.0 error_code_id={wait_code} error_msg={wait_error}\n"
    "BackUp backup_dist=0.30 backup_speed=0.15 error_code_id={back_code} error_msg={back_error}\n";
const std::string kSpin = "Spin spin_dist=1.57 error_code_id={spin_code} error_msg={spin_error}\n";
const std::string kWhereInvalid =
    "Fallback\nReactiveSequence\nInverter\nGlobalUpdatedGoal\nIsPathValid path={path}\n";
const std::string kWhereNewPathIsNeeded =
    "Fallback\nReactiveSequence\nInverter\nGlobalUpdatedGoal\n"
    "IsGoalNearby path={path} proximity_threshold=4.0 max_robot_pose_search_dist=1.5\n"
    "TruncatePathLocal input_path={path} output_path={rest} distance_forward=-1 "
    "distance_backward=0.0\n"
    "IsPathValid path={rest}\nValidatePath path={rest}\n";
const std::string kRoute =
    "ComputeRoute goal={goal} path={route_path} route={route} use_poses=true "
    "error_code_id={route_code} error_msg={route_error}\n"
    "WouldARouteRecoveryHelp error_code={route_code}\n"
    "WouldAPlannerRecoveryHelp error_code={route_code}\n";

const std::vector<OwnTree> kTrees = {
    {"follow_point",
     "PipelineSequence\n" + kSelectors +
         "RateController hz=1.0\nSequence\n"
         "GoalUpdater input_goal={goal} output_goal={updated}\n"
         "ComputePathToPose goal={updated} path={path} planner_id={planner} "
         "error_code_id={plan_code} error_msg={plan_error}\n"
         "TruncatePath distance=1.0 input_path={path} output_path={shorter}\n"
         "KeepRunningUntilFailure\n"
         "FollowPath path={shorter} controller_id={controller} error_code_id={follow_code} "
         "error_msg={follow_error}\n"},
    {"nav_to_pose_with_consistent_replanning_and_if_path_becomes_invalid",
     kSelectors + "RateController hz=2.0\n" + kWhereInvalid +
         "PathExpiringTimer seconds=10 path={path}\n" + kPlan + kFollow + kRecover + kSpin},
    {"navigate_on_route_graph_w_recovery",
     kSelectors + "RateController hz=0.5\n" + kWhereInvalid + kRoute +
         "GetCurrentPose current_pose={here}\n"
         "GetPoseFromPath path={route_path} index=0 pose={first}\n"
         "ArePosesNear ref_pose={here} target_pose={first} tolerance=0.3\n"
         "ComputePathToPose goal={first} path={first_mile} planner_id={planner} "
         "error_code_id={plan_code} error_msg={plan_error}\n"
         "ConcatenatePaths input_path1={first_mile} input_path2={route_path} "
         "output_path={route_path}\n"
         "GetPoseFromPath path={route_path} index=-1 pose={last}\n"
         "ArePosesNear ref_pose={goal} target_pose={last} tolerance=0.1\n"
         "ComputePathToPose start={last} goal={goal} path={last_mile} planner_id={planner}\n"
         "SmoothPath unsmoothed_path={route_path} smoothed_path={path} "
         "smoother_id=route_smoother error_code_id={smooth_code} error_msg={smooth_error}\n" +
         kWhereHelpful + kFollow + kRecover},
    {"navigate_through_poses_w_replanning_and_recovery",
     kMoreSelectors + kSelectors + "RateController hz=0.333\n" + kWhereNewPathIsNeeded +
         "RemovePassedGoals input_goals={goals} output_goals={goals} radius=0.7 "
         "input_waypoint_statuses={statuses} output_waypoint_statuses={statuses}\n"
         "ComputePathThroughPoses goals={goals} path={path} planner_id={planner} "
         "error_code_id={plan_code} error_msg={plan_error}\n" +
         kWhereHelpful + kFollowWithFeedback + kRecover + kSpin},
    {"the same of Jazzy and before",
     "RateController hz=0.333\n"
     "RemovePassedGoals input_goals={goals} output_goals={goals} radius=0.7\n"
     "ComputePathThroughPoses goals={goals} path={path} planner_id=GridBased "
     "error_code_id={plan_code}\n"
     "FollowPath path={path} controller_id=FollowPath error_code_id={follow_code}\n" +
         kWhereHelpful + kRecover + kSpin},
    {"navigate_to_pose_w_replanning_and_recovery",
     kMoreSelectors + kSelectors + "RateController hz=1.0\n" + kWhereNewPathIsNeeded + kPlan +
         kWhereHelpful + kFollowWithFeedback + kRecover + kSpin},
    {"navigate_to_pose_w_replanning_goal_patience_and_recovery",
     kSelectors + "RateController hz=1.0\n" + kPlan +
         "ReactiveSequence\nPathLongerOnApproach path={path} prox_len=3.0 length_factor=2.0\n"
         "RetryUntilSuccessful num_attempts=1\nSequenceWithMemory\nCancelControl\n" +
         kFollowWithFeedback + kRecover + kSpin},
    {"navigate_to_pose_w_bounds_check",
     kPlan +
         "ReactiveSequence\n"
         "IsWithinPathTrackingBounds max_error_left=0.5 max_error_right=0.5 "
         "max_error_heading=3.14 tracking_feedback={feedback}\n" +
         kFollowWithFeedback},
    {"navigate_w_recovery_and_replanning_only_if_path_becomes_invalid",
     kSelectors + "RateController hz=1.0\n" + kWhereInvalid + kPlan + kFollow + kRecover + kSpin},
    {"navigate_w_replanning_distance",
     kSelectors + "PipelineSequence\nDistanceController distance=1.0\n" + kPlan + kFollow},
    {"navigate_w_replanning_only_if_goal_is_updated",
     kSelectors + "PipelineSequence\nGoalUpdatedController\n" + kPlan + kFollow},
    {"navigate_w_replanning_only_if_path_becomes_invalid",
     kSelectors + "PipelineSequence\nRateController hz=1.0\n" + kWhereInvalid + kPlan + kFollow},
    {"navigate_w_replanning_speed",
     kSelectors +
         "PipelineSequence\nSpeedController min_rate=0.1 max_rate=1.0 min_speed=0.0 "
         "max_speed=0.26\n" +
         kPlan + kFollow},
    {"navigate_w_replanning_time",
     kSelectors + "PipelineSequence\nRateController hz=1.0\n" + kPlan + kFollow},
    {"navigate_w_routing_global_planning_and_control_w_recovery",
     kSelectors + "RateController hz=0.5\nRateController hz=1.0\n" + kWhereInvalid + kRoute +
         "ExtractRouteNodesAsGoals route={route} goals={route_goals}\n"
         "AppendGoalPoseToGoals input_goals={route_goals} output_goals={route_goals} "
         "goal_pose={goal}\n"
         "RemovePassedGoals input_goals={route_goals} output_goals={route_goals} radius=3.0\n"
         "GetNextFewGoals input_goals={route_goals} num_goals=2 output_goals={next_goals}\n"
         "ComputePathThroughPoses goals={next_goals} path={path} planner_id={planner} "
         "error_code_id={plan_code} error_msg={plan_error}\n" +
         kWhereHelpful + kFollow + kRecover},
    {"odometry_calibration",
     "Sequence\nDriveOnHeading dist_to_travel=0.2 speed=0.02 time_allowance=100\n" + kSpin},
};

// A node with the ports and values of a line of `uses`.
std::string XmlOf(const std::string& line, const Factory& factory) {
  std::istringstream words(line);
  std::string name, ports;
  words >> name;
  for (std::string port; words >> port;) {
    const std::size_t equals = port.find('=');
    ports += " " + port.substr(0, equals) + "=\"" + port.substr(equals + 1) + "\"";
  }
  const Factory::Registered* node = factory.Find(name);
  const bool has_children =
      node != nullptr && (node->kind == NodeKind::kControl || node->kind == NodeKind::kDecorator);
  if (!has_children) return "<" + name + ports + "/>\n";
  const std::string children =
      node->kind == NodeKind::kDecorator ? "<AlwaysSuccess/>" : "<AlwaysSuccess/><AlwaysSuccess/>";
  return "<" + name + ports + ">" + children + "</" + name + ">\n";
}
std::string XmlOf(const OwnTree& tree, const Factory& factory) {
  std::istringstream lines(tree.uses);
  std::string xml;
  for (std::string line; std::getline(lines, line);) xml += XmlOf(line, factory);
  return Main("<Sequence>\n" + xml + "</Sequence>");
}
std::set<std::string> NodesOf(const OwnTree& tree) {
  std::istringstream lines(tree.uses);
  std::set<std::string> names;
  for (std::string line; std::getline(lines, line);) names.insert(line.substr(0, line.find(' ')));
  return names;
}

TEST(Nav2OwnTrees, AreCheckedWithoutAFinding) {
  Factory factory;
  AddForCheck(factory);
  ASSERT_EQ(kTrees.size(), 16U);
  for (const OwnTree& tree : kTrees)
    EXPECT_EQ(Findings(XmlOf(tree, factory), factory), "") << tree.name;
}
// Two of them could not be ticked: those with a route.
TEST(Nav2OwnTrees, HaveNoNodeThatOnlyHasAModel) {
  FakeRobot robot;
  Factory factory;
  AddNodes(factory, robot);
  for (const OwnTree& tree : kTrees) {
    for (const std::string& name : NodesOf(tree)) {
      const Factory::Registered* node = factory.Find(name);
      ASSERT_NE(node, nullptr) << name;
      EXPECT_FALSE(node->placeholder) << tree.name << ": " << name;
    }
  }
}

}  // namespace musher::tree::nav2::own_trees_test
