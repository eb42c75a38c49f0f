// Trees of the shapes of nav2's own, on a robot with the planner, the controller, the route server
// and the recoveries of our programs, on a simulated network in virtual time.

#include <gmock/gmock.h>

#include <algorithm>
#include <memory>
#include <string>

#include "musher/behavior/tree/nav2/nodes.hpp"
#include "musher/messages/action_msgs/goal_status.hpp"
#include "musher/modules/skills/nav2/routed_robot.hpp"
#include "musher/modules/skills/robot/ros_robot.hpp"
#include "musher/test/behavior/tree/trees.hpp"
#include "musher/test/modules/navigation/servers_on_network.hpp"
#include "musher/test/modules/navigation/simulated_robot.hpp"
#include "musher/test/navigation/maps.hpp"
#include "musher/test/navigation/route_graphs.hpp"
#include "musher/transport/action_names.hpp"
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
  skills::RouteClient routes_{endpoints_, "a/compute_route", "a/compute_and_track_route"};
  skills::RoutedRobot nav2_{robot_, routes_};
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

// On a graph of the hall, whose edges lead both ways; the edge from a to b has the id 10 a + b:
//
//   4 (2, 5) ---- 5 (6, 5.4) -- 6 (10.5, 5)
//   |             |             |
//   1 (2, 1.2) -- 2 (6, 1.2) -- 3 (10.5, 1.2)
class Nav2OnAGraph : public Nav2OnARobot {
 protected:
  Nav2OnAGraph() {
    std::vector<navigation::testing::EdgeBetween> edges;
    const std::vector<std::pair<int, int>> both_ways = {{1, 2}, {2, 3}, {4, 5}, {5, 6},
                                                        {1, 4}, {2, 5}, {3, 6}};
    const auto add = [&edges](int from, int to) {
      edges.push_back({static_cast<navigation::RouteId>(10 * from + to),
                       static_cast<navigation::RouteId>(from),
                       static_cast<navigation::RouteId>(to)});
    };
    for (const auto& [one, other] : both_ways) {
      add(one, other);
      add(other, one);
    }
    navigation::RouteConfig routes;
    routes.graph = std::make_shared<const navigation::RouteGraph>(
        navigation::testing::GraphOf({{1, {2, 1.2, 0}},
                                      {2, {6, 1.2, 0}},
                                      {3, {10.5, 1.2, 0}},
                                      {4, {2, 5, 0}},
                                      {5, {6, 5.4, 0}},
                                      {6, {10.5, 5, 0}}},
                                     edges));
    routes.robots = {navigation::testing::RouteTable("a")};
    servers_.StartRoutes(routes);
    Run(1.5);
  }
  bool Close(std::vector<std::uint16_t> edges) {
    const auto client = Must(transport::MakeClient<msg::DynamicEdges>(
        *peers_, "route_server/DynamicEdgesScorer/adjust_edges"));
    Run(1);
    std::optional<bool> success;
    msg::DynamicEdges::Request request;
    request.closed_edges = std::move(edges);
    client->Call(request, Milliseconds(1000),
                 [&](const auto& reply) { success = reply && reply.value().success; });
    Run(1);
    return success.value_or(false);
  }
  // The nearest that it has come to a place, until the tree ends.
  double NearestTo(double x_m, double y_m, double seconds) {
    double nearest_m = 100;
    for (int i = 0; i < seconds * 10 && letter_ == 'R'; ++i) {
      Run(0.1);
      nearest_m = std::min(nearest_m, OffFrom(x_m, y_m));
    }
    return nearest_m;
  }
  std::string Code(const std::string& key) {
    const auto code = tree_->board().Get<int>(key);
    return code ? std::to_string(code.value()) : code.error().message;
  }
};

const std::string kComputeRoute =
    "<ComputeRoute goal=\"{goal}\" path=\"{route_path}\" route=\"{route}\" use_poses=\"true\" "
    "error_code_id=\"{route_code}\" error_msg=\"{route_error}\"/>";
// Recovers by what may help a route, a plan or a drive, as nav2's trees with routes do.
std::string WithRouteRecoveries(const std::string& content) {
  return "<RecoveryNode number_of_retries=\"6\"><PipelineSequence>"
         "<ControllerSelector selected_controller=\"{c}\" default_controller=\"FollowPath\"/>"
         "<PlannerSelector selected_planner=\"{p}\" default_planner=\"GridBased\"/>" +
         content + "<RecoveryNode number_of_retries=\"1\">" + kFollow +
         "<Sequence><WouldAControllerRecoveryHelp error_code=\"{follow_code}\"/>" + kClear +
         "</Sequence></RecoveryNode></PipelineSequence><Sequence><Fallback>"
         "<WouldAControllerRecoveryHelp error_code=\"{follow_code}\"/>"
         "<WouldAPlannerRecoveryHelp error_code=\"{route_code}\"/></Fallback>"
         "<ReactiveFallback><GoalUpdated/><RoundRobin><Sequence>" +
         kClear + kClear +
         "</Sequence><Wait wait_duration=\"5.0\"/><BackUp backup_dist=\"0.30\" "
         "backup_speed=\"0.15\"/></RoundRobin></ReactiveFallback></Sequence></RecoveryNode>";
}
std::string RouteIfInvalid(const std::string& path, const std::string& steps,
                           const std::string& helps) {
  return "<RecoveryNode number_of_retries=\"1\"><RateController hz=\"0.5\"><Fallback>"
         "<ReactiveSequence><Inverter><GlobalUpdatedGoal/></Inverter><IsPathValid path=\"" +
         path + "\"/></ReactiveSequence><Sequence>" + kComputeRoute + steps +
         "</Sequence></Fallback></RateController><Sequence><Fallback>"
         "<WouldARouteRecoveryHelp error_code=\"{route_code}\"/>" +
         helps + "</Fallback>" + kClear + "</Sequence></RecoveryNode>";
}
// navigate_on_route_graph_w_recovery: along the edges, with a plan to the first node and from the
// last one. `around` each of both: a decorator; empty: as nav2 has it.
std::string OnRouteGraph(const std::string& around) {
  const auto in = [&around](const std::string& mile) {
    return around.empty() ? mile : "<" + around + ">" + mile + "</" + around + ">";
  };
  return WithRouteRecoveries(RouteIfInvalid(
      "{path}",
      in("<ReactiveSequence><GetCurrentPose current_pose=\"{here}\"/>"
         "<GetPoseFromPath path=\"{route_path}\" index=\"0\" pose=\"{first}\"/>"
         "<Inverter><ArePosesNear ref_pose=\"{here}\" target_pose=\"{first}\" tolerance=\"0.3\"/>"
         "</Inverter><ComputePathToPose goal=\"{first}\" path=\"{first_mile}\" planner_id=\"{p}\" "
         "error_code_id=\"{plan_code}\"/>"
         "<ConcatenatePaths input_path1=\"{first_mile}\" input_path2=\"{route_path}\" "
         "output_path=\"{route_path}\"/></ReactiveSequence>") +
          in("<ReactiveSequence><GetPoseFromPath path=\"{route_path}\" index=\"-1\" "
             "pose=\"{last}\"/>"
             "<Inverter><ArePosesNear ref_pose=\"{goal}\" target_pose=\"{last}\" "
             "tolerance=\"0.1\"/></Inverter><ComputePathToPose start=\"{last}\" goal=\"{goal}\" "
             "path=\"{last_mile}\" planner_id=\"{p}\" error_code_id=\"{plan_code}\"/>"
             "<ConcatenatePaths input_path1=\"{route_path}\" input_path2=\"{last_mile}\" "
             "output_path=\"{route_path}\"/></ReactiveSequence>") +
          "<SmoothPath unsmoothed_path=\"{route_path}\" smoothed_path=\"{path}\" "
          "smoother_id=\"route_smoother\" error_code_id=\"{smooth_code}\"/>",
      "<WouldAPlannerRecoveryHelp error_code=\"{plan_code}\"/>"));
}
const std::string kOnRouteGraph = OnRouteGraph("");
// navigate_w_routing_global_planning_and_control_w_recovery: through the nodes, by plans.
const std::string kThroughRouteNodes = WithRouteRecoveries(
    RouteIfInvalid("{route_path}",
                   "<ExtractRouteNodesAsGoals route=\"{route}\" goals=\"{route_goals}\"/>"
                   "<AppendGoalPoseToGoals input_goals=\"{route_goals}\" "
                   "output_goals=\"{route_goals}\" goal_pose=\"{goal}\"/>",
                   "") +
    "<RateController hz=\"1.0\"><RecoveryNode number_of_retries=\"1\"><Sequence>"
    "<RemovePassedGoals input_goals=\"{route_goals}\" output_goals=\"{route_goals}\" "
    "radius=\"3.0\"/><GetNextFewGoals input_goals=\"{route_goals}\" num_goals=\"2\" "
    "output_goals=\"{planning_goals}\"/><ComputePathThroughPoses goals=\"{planning_goals}\" "
    "path=\"{path}\" planner_id=\"{p}\" error_code_id=\"{plan_code}\"/></Sequence><Sequence>"
    "<WouldAPlannerRecoveryHelp error_code=\"{plan_code}\"/>" +
    kClear + "</Sequence></RecoveryNode></RateController>");

TEST_F(Nav2OnAGraph, DrivesAlongTheEdgesOfItsRoute) {
  Begin(kOnRouteGraph);
  Put("goal", Pose{.x_m = 11.2, .y_m = 5.5, .stamp = Now()});
  double nearest_m[2] = {100, 100}, off_m = 0;
  for (int i = 0; i < 900 && letter_ == 'R'; ++i) {
    Run(0.1);
    const navigation::Point at = body_.pose().at;
    nearest_m[0] = std::min(nearest_m[0], OffFrom(2, 1.2));
    nearest_m[1] = std::min(nearest_m[1], OffFrom(10.5, 1.2));
    // Between 1 and 3 it is on the edge.
    if (at.x_m > 3 && at.x_m < 9.5) off_m = std::max(off_m, std::abs(at.y_m - 1.2));
  }
  EXPECT_EQ(letter_, 'S') << Code("route_code") << Code("plan_code") << Code("follow_code");
  EXPECT_LT(OffFrom(11.2, 5.5), 0.5);
  EXPECT_LT(nearest_m[0], 0.4);
  EXPECT_LT(nearest_m[1], 0.4);
  EXPECT_LT(off_m, 0.2);
  EXPECT_GT(body_.least_room_m(), 0);
}

// It stands at the first node: the ReactiveSequence of the first mile fails, and nothing catches
// that. A ForceSuccess does.
TEST_F(Nav2OnARobot, FailsAtTheFirstNodeOfItsRouteAsNav2DoesUnlessThatIsCaught) {
  navigation::RouteConfig routes;
  routes.graph = std::make_shared<const navigation::RouteGraph>(
      navigation::testing::GraphOf({{1, {1, 3, 0}}, {2, {9, 3, 0}}}, {{12, 1, 2}}));
  routes.robots = {navigation::testing::RouteTable("a")};
  servers_.StartRoutes(routes);
  Run(1.5);
  Begin(OnRouteGraph(""));
  Put("goal", Pose{.x_m = 9, .y_m = 4, .stamp = Now()});
  EXPECT_EQ(RunToTheEnd(60), 'F');
  EXPECT_LT(OffFrom(1, 3), 0.05);
  Begin(OnRouteGraph("ForceSuccess"));
  Put("goal", Pose{.x_m = 9, .y_m = 4, .stamp = Now()});
  EXPECT_EQ(RunToTheEnd(60), 'S');
  EXPECT_LT(OffFrom(9, 4), 0.5);
}

TEST_F(Nav2OnAGraph, DrivesThroughTheNodesOfItsRoute) {
  Begin(kThroughRouteNodes);
  Put("goal", Pose{.x_m = 11.2, .y_m = 5.5, .stamp = Now()});
  EXPECT_LT(NearestTo(10.5, 1.2, 90), 3.1) << "a node is passed within 3 m";
  EXPECT_EQ(letter_, 'S') << Code("route_code") << Code("plan_code") << Code("follow_code");
  EXPECT_LT(OffFrom(11.2, 5.5), 0.5);
  EXPECT_GT(body_.least_room_m(), 0);
}

TEST_F(Nav2OnAGraph, GoesAnotherWayWhereAnEdgeIsClosed) {
  ASSERT_TRUE(Close({23}));
  Begin(kOnRouteGraph);
  Put("goal", Pose{.x_m = 11.2, .y_m = 1.0, .stamp = Now()});
  EXPECT_LT(NearestTo(10.5, 5, 120), 0.4);
  EXPECT_EQ(letter_, 'S') << Code("route_code") << Code("plan_code") << Code("follow_code");
  EXPECT_LT(OffFrom(11.2, 1.0), 0.5);
}

TEST_F(Nav2OnAGraph, DrivesNowhereWhereNoRouteLeadsToItsGoal) {
  ASSERT_TRUE(Close({23, 56}));
  Begin(kOnRouteGraph);
  Put("goal", Pose{.x_m = 11.2, .y_m = 5.5, .stamp = Now()});
  EXPECT_EQ(RunToTheEnd(90), 'F');
  EXPECT_EQ(Code("route_code"), "405");
  EXPECT_LT(OffFrom(1, 3), 0.05);
}

TEST_F(Nav2OnAGraph, GoesToAnotherGoalThatComesOnItsWay) {
  Begin(kThroughRouteNodes);
  Put("goal", Pose{.x_m = 11.2, .y_m = 5.5, .stamp = Now()});
  Run(5);
  EXPECT_EQ(letter_, 'R');
  Put("goal", Pose{.x_m = 1.5, .y_m = 5.5, .stamp = Now()});
  EXPECT_EQ(RunToTheEnd(90), 'S');
  EXPECT_LT(OffFrom(1.5, 5.5), 0.5);
}

// The tracker watches while another branch drives.
TEST_F(Nav2OnAGraph, TracksItsRouteWhileItDrives) {
  Begin(
      "<Parallel success_count=\"2\" failure_count=\"1\">"
      "<ComputeAndTrackRoute goal=\"{goal}\" use_poses=\"true\" last_node_id=\"{last}\" "
      "next_node_id=\"{next}\" current_edge_id=\"{edge}\" path=\"{path}\" "
      "error_code_id=\"{track_code}\"/>"
      "<Sequence><Delay delay_msec=\"500\"><AlwaysSuccess/></Delay>"
      "<GetPoseFromPath path=\"{path}\" index=\"0\" pose=\"{first}\"/>"
      "<ComputePathToPose goal=\"{first}\" path=\"{mile}\"/>"
      "<ConcatenatePaths input_path1=\"{mile}\" input_path2=\"{path}\" output_path=\"{way}\"/>"
      "<FollowPath path=\"{way}\"/></Sequence></Parallel>");
  Put("goal", Pose{.x_m = 10.5, .y_m = 1.2, .stamp = Now()});
  std::vector<std::string> places;
  for (int i = 0; i < 900 && letter_ == 'R'; ++i) {
    Run(0.1);
    const std::string place = Code("last") + "-" + Code("edge") + "-" + Code("next");
    if (places.empty() || places.back() != place) places.push_back(place);
  }
  EXPECT_EQ(letter_, 'S') << Code("track_code");
  EXPECT_THAT(places, ::testing::IsSupersetOf({"0-0-1", "1-12-2", "2-23-3"}));
}

TEST_F(Nav2OnAGraph, FailsToTrackWithoutAPose) {
  Begin(
      "<ComputeAndTrackRoute start_id=\"1\" goal_id=\"3\" error_code_id=\"{track_code}\" "
      "error_msg=\"{why}\"/>");
  Run(1);
  EXPECT_EQ(letter_, 'R');
  body_.odometry_silent = true;
  EXPECT_EQ(RunToTheEnd(2), 'F');
  EXPECT_EQ(Code("track_code"), "401");
}

TEST_F(Nav2OnAGraph, TracksNoMoreWhereTheTreeIsHalted) {
  std::vector<int> statuses;
  const auto status = Must(transport::MakeSubscription<msg::GoalStatusArray>(
      *peers_, transport::StatusTopic("a/compute_and_track_route"),
      [&statuses](const msg::GoalStatusArray& goals, const auto&) {
        if (!goals.status_list.empty()) statuses.push_back(goals.status_list.back().status);
      },
      transport::kLatchedQos));
  Begin("<ComputeAndTrackRoute start_id=\"1\" goal_id=\"3\" next_node_id=\"{next}\"/>");
  Run(1);
  EXPECT_EQ(Code("next"), "1");
  ASSERT_FALSE(statuses.empty());
  EXPECT_EQ(statuses.back(), msg::GoalStatus::kStatusExecuting);
  ASSERT_TRUE(tree_->Halt(Now()));
  letter_ = '-';
  Run(1);
  EXPECT_EQ(Code("next"), "0");
  EXPECT_EQ(statuses.back(), msg::GoalStatus::kStatusCanceled);
}

TEST_F(Nav2OnAGraph, TracksNoMoreWhereTheTreeCancelsItsRoute) {
  Begin(
      "<Parallel success_count=\"2\" failure_count=\"2\">"
      "<ComputeAndTrackRoute start_id=\"1\" goal_id=\"3\" next_node_id=\"{next}\" "
      "error_code_id=\"{track_code}\" error_msg=\"{why}\"/>"
      "<Sequence><Delay delay_msec=\"1000\"><AlwaysSuccess/></Delay>"
      "<CancelComputeAndTrackRoute/><Wait wait_duration=\"1\"/><AlwaysFailure/></Sequence>"
      "</Parallel>");
  Run(0.8);
  EXPECT_EQ(Code("next"), "1");
  EXPECT_EQ(RunToTheEnd(5), 'F');
  EXPECT_EQ(Code("track_code"), "400");
  EXPECT_EQ(tree_->board().Get<std::string>("why").value(), "the route was cancelled");
}

// Its server has not accepted the goal when all are cancelled.
TEST_F(Nav2OnAGraph, TracksNoMoreWhereItsRouteIsCancelledInTheTickInWhichItBegins) {
  Begin(
      "<Parallel success_count=\"2\" failure_count=\"1\">"
      "<ComputeAndTrackRoute start_id=\"1\" goal_id=\"3\" error_code_id=\"{track_code}\" "
      "error_msg=\"{why}\"/>"
      "<CancelComputeAndTrackRoute/></Parallel>");
  EXPECT_EQ(RunToTheEnd(5), 'F');
  EXPECT_EQ(Code("track_code"), "400");
  EXPECT_EQ(tree_->board().Get<std::string>("why").value(), "the route was cancelled");
}

TEST_F(Nav2OnARobot, CancelsNoRouteWithoutARouteServer) {
  Begin("<CancelComputeAndTrackRoute/>");
  EXPECT_EQ(RunToTheEnd(5), 'F');
}

TEST_F(Nav2OnARobot, FailsARouteWithoutARouteServer) {
  Begin(
      "<ComputeRoute goal=\"5;3;0\" use_poses=\"true\" error_code_id=\"{code}\" "
      "error_msg=\"{why}\"/>");
  EXPECT_EQ(RunToTheEnd(5), 'F');
  EXPECT_EQ(tree_->board().Get<int>("code").value(), 400);
  EXPECT_EQ(tree_->board().Get<std::string>("why").value(), "there is no route server");
}

}  // namespace musher::nav2_trees_test
