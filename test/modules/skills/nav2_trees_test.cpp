// Trees of the shapes of nav2's own, on a robot with the planner, the controller and the recoveries
// of our programs, on a simulated network in virtual time.

#include <gmock/gmock.h>

#include <algorithm>
#include <memory>
#include <string>

#include "musher/behavior/tree/nav2/nodes.hpp"
#include "musher/modules/skills/nav2/tree_robot.hpp"
#include "musher/modules/skills/robot/ros_robot.hpp"
#include "musher/test/behavior/tree/trees.hpp"
#include "musher/test/modules/navigation/servers_on_network.hpp"
#include "musher/test/modules/navigation/simulated_robot.hpp"
#include "musher/test/navigation/maps.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::nav2_trees_test {

using navigation::testing::ServersOnNetwork;
using navigation::testing::SimulatedRobot;
using tree::nav2::Pose;

template <class T>
T Must(Result<T> result) {
  if (!result) ADD_FAILURE() << result.error().message;
  return std::move(result).value();
}

// A hall of 12 x 6 m in which a robot stands at (1, 3).
class Nav2OnARobot : public ::testing::Test {
 protected:
  Nav2OnARobot() {
    navigation::PlannerConfig planner;
    planner.robots = {navigation::testing::PlannerTable("a")};
    navigation::ControllerConfig controller;
    controller.robots = {navigation::testing::ControllerTable("a")};
    servers_.Start(planner, controller);
    map_ =
        Must(transport::MakePublisher<msg::OccupancyGrid>(*peers_, "map", transport::kLatchedQos));
    EXPECT_TRUE(map_->Publish(navigation::testing::GridOf(walls_.map())));
    robot_.Open(endpoints_, "");
    tree::nav2::AddNodes(factory_, nav2_);
    steps_ = node_->loop().Every(Milliseconds(100), [this] {
      robot_.BeginStep(node_->loop().Now());
      if (tree_ == nullptr || letter_ != 'R') return;
      const auto result = tree_->TickOnce(node_->loop().Now());
      EXPECT_TRUE(result) << result.error().message;
      letter_ = tree::Letter(result);
    });
    Run(1.5);
  }

  void Begin(const std::string& content) {
    tree_ = tree::MakeTree(tree::Main(content), factory_);
    ASSERT_TRUE(tree_);
    letter_ = 'R';
  }
  void Run(double seconds) { network_.RunFor(FromSeconds(seconds)); }
  char RunToTheEnd(double seconds) {
    network_.RunUntil([this] { return letter_ != 'R'; }, network_.now() + FromSeconds(seconds));
    return letter_;
  }
  template <class T>
  void Put(const std::string& key, const T& value) {
    ASSERT_TRUE(tree_->board().Set(key, value));
  }
  Time Now() { return node_->loop().Now(); }
  double OffFrom(double x_m, double y_m) const {
    return std::hypot(body_.pose().at.x_m - x_m, body_.pose().at.y_m - y_m);
  }
  static skills::SkillsConfig Config() {
    const auto reading = skills::ReadSkillsText(
        "robot = \"a\"\nkind = \"jetbot\"\nradius_m = 0.2\n[topics]\nobjects = \"\"\n",
        "/tmp/robot.toml");
    return *reading.config;
  }

  transport::sim::Network network_{1};
  ServersOnNetwork servers_{network_};
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> peers_ = network_.MakeNode("robot");
  const navigation::Clearance walls_{
      navigation::testing::Carved(13, 7, 0.05, {{0.5, 0.5, 12.5, 6.5}})};
  SimulatedRobot body_{*peers_, walls_, {.name = "a", .start = {{1, 3, 0}, 0}}};
  std::unique_ptr<transport::Publisher<msg::OccupancyGrid>> map_;
  skills::RosRobot robot_{Config()};
  transport::Endpoints endpoints_{*node_, ""};
  skills::TreeRobot nav2_{robot_};
  tree::Factory factory_;
  std::unique_ptr<tree::Tree> tree_;
  char letter_ = '-';
  transport::LoopHandlePtr steps_;
};

std::string Pipeline(const std::string& plans, const std::string& follows) {
  return "<PipelineSequence>"
         "<ControllerSelector selected_controller=\"{c}\" default_controller=\"FollowPath\"/>"
         "<PlannerSelector selected_planner=\"{p}\" default_planner=\"GridBased\"/>" +
         plans + follows + "</PipelineSequence>";
}
const std::string kPlan =
    "<ComputePathToPose goal=\"{goal}\" path=\"{path}\" planner_id=\"{p}\" "
    "error_code_id=\"{plan_code}\"/>";
const std::string kPlanThrough =
    "<ReactiveSequence><RemovePassedGoals input_goals=\"{goals}\" output_goals=\"{goals}\" "
    "radius=\"0.7\"/><ComputePathThroughPoses goals=\"{goals}\" path=\"{path}\" "
    "error_code_id=\"{plan_code}\"/></ReactiveSequence>";
const std::string kFollow =
    "<FollowPath path=\"{path}\" controller_id=\"{c}\" error_code_id=\"{follow_code}\" "
    "tracking_feedback=\"{tracking}\"/>";
const std::string kClear = "<ClearEntireCostmap service_name=\"global\"/>";

// `plan` where the goal is new, or the path is not free any more.
std::string IfInvalid(const std::string& plan, const std::string& more = "") {
  return "<Fallback><ReactiveSequence>" + more +
         "<Inverter><GlobalUpdatedGoal/></Inverter><IsPathValid path=\"{path}\"/>"
         "</ReactiveSequence>" +
         plan + "</Fallback>";
}
// `plan` unless the goal is near, and the rest of the path is free.
std::string IfNeeded(const std::string& plan) {
  return "<Fallback><ReactiveSequence><Inverter><GlobalUpdatedGoal/></Inverter>"
         "<IsGoalNearby path=\"{path}\" proximity_threshold=\"4.0\" "
         "max_robot_pose_search_dist=\"1.5\"/><TruncatePathLocal input_path=\"{path}\" "
         "output_path=\"{rest}\" distance_forward=\"-1\" distance_backward=\"0.0\"/>"
         "<ValidatePath path=\"{rest}\"/></ReactiveSequence>" +
         plan + "</Fallback>";
}
// Clears and tries again where that may help, and then recovers by motions.
std::string WithRecoveries(const std::string& rate, const std::string& plans) {
  const auto contextual = [](const std::string& tried, const std::string& helps) {
    return "<RecoveryNode number_of_retries=\"1\">" + tried + "<Sequence>" + helps + kClear +
           "</Sequence></RecoveryNode>";
  };
  const std::string planner_helps = "<WouldAPlannerRecoveryHelp error_code=\"{plan_code}\"/>";
  const std::string controller_helps =
      "<WouldAControllerRecoveryHelp error_code=\"{follow_code}\"/>";
  return "<RecoveryNode number_of_retries=\"6\">" +
         Pipeline("<RateController hz=\"" + rate + "\">" + contextual(plans, planner_helps) +
                      "</RateController>",
                  contextual(kFollow, controller_helps)) +
         "<Sequence><Fallback>" + controller_helps + planner_helps +
         "</Fallback><ReactiveFallback><GoalUpdated/><RoundRobin><Sequence>" + kClear + kClear +
         "</Sequence><Spin spin_dist=\"1.57\"/><Wait wait_duration=\"5.0\"/>"
         "<BackUp backup_dist=\"0.30\" backup_speed=\"0.15\"/></RoundRobin></ReactiveFallback>"
         "</Sequence></RecoveryNode>";
}
std::string AtRate(const std::string& hz, const std::string& plans) {
  return "<RateController hz=\"" + hz + "\">" + plans + "</RateController>";
}

struct Shape {
  std::string name;
  std::string tree;
};
const std::vector<Shape> kToPose = {
    {"w_replanning_and_recovery", WithRecoveries("1.0", IfNeeded(kPlan))},
    {"recovery_and_only_if_path_becomes_invalid", WithRecoveries("1.0", IfInvalid(kPlan))},
    {"consistent_replanning_and_if_path_becomes_invalid",
     WithRecoveries("2.0", IfInvalid(kPlan,
                                     "<Inverter><PathExpiringTimer seconds=\"10\" "
                                     "path=\"{path}\"/></Inverter>"))},
    {"goal_patience",
     Pipeline(AtRate("1.0", kPlan),
              "<ReactiveSequence><PathLongerOnApproach path=\"{path}\" prox_len=\"3.0\" "
              "length_factor=\"2.0\"><RetryUntilSuccessful num_attempts=\"1\">"
              "<SequenceWithMemory><CancelControl/><Wait wait_duration=\"5.0\"/>"
              "</SequenceWithMemory></RetryUntilSuccessful></PathLongerOnApproach>" +
                  kFollow + "</ReactiveSequence>")},
    {"bounds_check", "<Sequence>" + kPlan +
                         "<ReactiveSequence><IsWithinPathTrackingBounds max_error_left=\"0.5\" "
                         "max_error_right=\"0.5\" tracking_feedback=\"{tracking}\"/>" +
                         kFollow + "</ReactiveSequence></Sequence>"},
    {"only_if_path_becomes_invalid", Pipeline(AtRate("1.0", IfInvalid(kPlan)), kFollow)},
    {"only_if_goal_is_updated",
     Pipeline("<GoalUpdatedController>" + kPlan + "</GoalUpdatedController>", kFollow)},
    {"distance",
     Pipeline("<DistanceController distance=\"1.0\">" + kPlan + "</DistanceController>", kFollow)},
    {"speed", Pipeline("<SpeedController min_rate=\"0.1\" max_rate=\"1.0\" min_speed=\"0.0\" "
                       "max_speed=\"0.26\">" +
                           kPlan + "</SpeedController>",
                       kFollow)},
    {"time", Pipeline(AtRate("1.0", kPlan), kFollow)},
};

class ToPose : public Nav2OnARobot, public ::testing::WithParamInterface<Shape> {};
TEST_P(ToPose, ArrivesWithoutAContact) {
  Begin(GetParam().tree);
  Put("goal", Pose{.x_m = 9, .y_m = 4, .stamp = Now()});
  EXPECT_EQ(RunToTheEnd(90), 'S');
  EXPECT_LT(OffFrom(9, 4), 0.5);
  EXPECT_GT(body_.least_room_m(), 0);
}
INSTANTIATE_TEST_SUITE_P(Nav2, ToPose, ::testing::ValuesIn(kToPose),
                         [](const auto& shape) { return shape.param.name; });

// It comes to rest a little behind its goal, and the next plan leads back to it.
TEST_F(Nav2OnARobot, DoesNotTurnRoundAtItsGoal) {
  Begin(kToPose.back().tree);
  Put("goal", Pose{.x_m = 9, .y_m = 4, .stamp = Now()});
  double most_rad = 0;
  for (int i = 0; i < 300 && letter_ == 'R'; ++i) {
    Run(0.1);
    most_rad = std::max(most_rad, std::abs(body_.pose().yaw_rad));
  }
  EXPECT_EQ(letter_, 'S');
  EXPECT_LT(most_rad, 0.5);
}

// Those that plan again where the path is not free.
class AroundADisc : public Nav2OnARobot, public ::testing::WithParamInterface<Shape> {};
TEST_P(AroundADisc, ThatAppearsOnItsPath) {
  Begin(GetParam().tree);
  Put("goal", Pose{.x_m = 10, .y_m = 3, .stamp = Now()});
  Run(2);
  body_.discs = {{{7, 3, 0}, 0.3}};
  EXPECT_EQ(RunToTheEnd(120), 'S');
  EXPECT_LT(OffFrom(10, 3), 0.5);
  EXPECT_GT(body_.least_room_m(), 0);
}
INSTANTIATE_TEST_SUITE_P(Nav2, AroundADisc,
                         ::testing::Values(kToPose[0], kToPose[1], kToPose[2], kToPose[5]),
                         [](const auto& shape) { return shape.param.name; });

// Its odometry is not still to the last digit, so that each plan is another path.
TEST_F(Nav2OnARobot, RecoversFromADiscThatAppearsTooNearToPlanAroundIt) {
  Begin(kToPose[2].tree);
  Put("goal", Pose{.x_m = 10, .y_m = 3, .stamp = Now()});
  network_.RunUntil([this] { return body_.pose().at.x_m > 5.2; }, network_.now() + FromSeconds(9));
  body_.discs = {{{5.85, 3, 0}, 0.3}};
  EXPECT_EQ(RunToTheEnd(120), 'S');
  EXPECT_LT(OffFrom(10, 3), 0.5);
  EXPECT_GT(body_.least_room_m(), 0);
}

TEST_F(Nav2OnARobot, TravelsThroughPlaces) {
  Begin(WithRecoveries("0.333", IfNeeded(kPlanThrough)));
  const tree::nav2::Goals goals{
      {Pose{.x_m = 6, .y_m = 2}, Pose{.x_m = 9, .y_m = 5}, Pose{.x_m = 3, .y_m = 5}}};
  Put("goals", goals);
  double nearest_m[2] = {10, 10};
  for (int i = 0; i < 1200 && letter_ == 'R'; ++i) {
    Run(0.1);
    nearest_m[0] = std::min(nearest_m[0], OffFrom(6, 2));
    nearest_m[1] = std::min(nearest_m[1], OffFrom(9, 5));
  }
  EXPECT_EQ(letter_, 'S');
  EXPECT_LT(nearest_m[0], 0.71);
  EXPECT_LT(nearest_m[1], 0.71);
  EXPECT_LT(OffFrom(3, 5), 0.5);
  EXPECT_GT(body_.least_room_m(), 0);
}

TEST_F(Nav2OnARobot, FollowsAPointAtADistance) {
  Begin(Pipeline(AtRate("1.0",
                        "<Sequence><GoalUpdater input_goal=\"{goal}\" output_goal=\"{point}\">"
                        "<ComputePathToPose goal=\"{point}\" path=\"{all}\"/></GoalUpdater>"
                        "<TruncatePath distance=\"1.0\" input_path=\"{all}\" "
                        "output_path=\"{path}\"/></Sequence>"),
                 "<KeepRunningUntilFailure>" + kFollow + "</KeepRunningUntilFailure>"));
  Put("goal", Pose{.x_m = 5, .y_m = 3, .stamp = Now()});
  Run(25);
  EXPECT_EQ(letter_, 'R');
  EXPECT_NEAR(OffFrom(5, 3), 1, 0.35);
  const navigation::Point stood = body_.pose().at;
  Run(10);
  EXPECT_LT(OffFrom(stood.x_m, stood.y_m), 0.2) << "it stays where it is";
  nav2_.SetGoalUpdate(Pose{.x_m = 9, .y_m = 4, .stamp = Now()});
  Run(25);
  EXPECT_EQ(letter_, 'R');
  EXPECT_NEAR(OffFrom(9, 4), 1, 0.35);
}

TEST_F(Nav2OnARobot, IsStoppedWhereItLeavesTheBoundsOfItsPath) {
  Begin("<Sequence>" + kPlan +
        "<ReactiveSequence><IsWithinPathTrackingBounds max_error_left=\"0.2\" "
        "max_error_right=\"0.2\" tracking_feedback=\"{tracking}\"/>" +
        kFollow + "</ReactiveSequence></Sequence>");
  Put("goal", Pose{.x_m = 10, .y_m = 3, .stamp = Now()});
  Run(4);
  EXPECT_EQ(letter_, 'R');
  EXPECT_GT(body_.speed_m_s(), 0.1);
  body_.odometry_off = {0, 0.4, 0};
  EXPECT_EQ(RunToTheEnd(2), 'F');
  Run(2);
  EXPECT_LT(body_.speed_m_s(), 0.01);
}

TEST_F(Nav2OnARobot, DrivesInASquare) {
  std::string square = "<Sequence>";
  for (int side = 0; side < 4; ++side) {
    square +=
        "<DriveOnHeading dist_to_travel=\"0.2\" speed=\"0.02\" time_allowance=\"100\"/>"
        "<Spin spin_dist=\"1.57\"/>";
  }
  Begin(square + "</Sequence>");
  EXPECT_EQ(RunToTheEnd(120), 'S');
  EXPECT_LT(OffFrom(1, 3), 0.15);
}

}  // namespace musher::nav2_trees_test
