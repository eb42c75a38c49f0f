// The nodes of nav2 for routes and smooth paths, on a robot that a test scripts.

#include <cmath>

#include "musher/test/behavior/tree/nav2/fake_robot.hpp"

namespace musher::tree::nav2::routes_test {

using testing::ElementsAre;
using testing::HasSubstr;

Route Corner() {
  return {{{1, 0, 0, 0}, {2, 3, 0, 0}, {3, 3, 4, 0}}, {12, 23}, 7};
}

using AComputeRoute = Nav2Tree;
TEST_F(AComputeRoute, GivesRouteAndPathAndTheCode) {
  Make(
      "<ComputeRoute goal=\"{goal}\" use_poses=\"true\" route=\"{route}\" path=\"{path}\" "
      "planning_time=\"{t}\" error_code_id=\"{code}\" error_msg=\"{why}\"/>");
  Put("goal", Pose{.x_m = 4});
  EXPECT_EQ(Next(), "R ");
  EXPECT_EQ(robot.Take(), "route to 4; ");
  robot.ends["route"] = {.success = true, .path = Straight(4), .route = Corner()};
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(tree->board().Get<Route>("route").value(), Corner());
  EXPECT_EQ(tree->board().Get<Path>("path").value(), Straight(4));
  EXPECT_EQ(tree->board().Get<int>("code").value(), 0);
  robot.ends["route"] = {.error_code = kNoValidRoute, .error = "closed", .route = Corner()};
  EXPECT_EQ(Next(), "F ");
  EXPECT_EQ(tree->board().Get<Route>("route").value(), Route{});
  EXPECT_EQ(tree->board().Get<Path>("path").value(), Path{});
  EXPECT_EQ(tree->board().Get<int>("code").value(), 405);
  EXPECT_EQ(tree->board().Get<std::string>("why").value(), "closed");
  robot.ends["route"] = {.error = "?"};
  EXPECT_EQ(Next(), "F ");
  EXPECT_EQ(tree->board().Get<int>("code").value(), 400);
}
TEST_F(AComputeRoute, BeginsAtItsStartOnlyWithUseStart) {
  Make("<ComputeRoute goal=\"4;0;0\" start=\"1;0;0\" use_poses=\"true\"/>");
  Next();
  EXPECT_EQ(robot.Take(), "route to 4; ");
  Make("<ComputeRoute goal=\"4;0;0\" start=\"1;0;0\" use_poses=\"true\" use_start=\"true\"/>");
  Next();
  EXPECT_THAT(robot.Take(), HasSubstr("route from 1 to 4; "));
}
TEST_F(AComputeRoute, LeadsFromNodeToNodeWithoutUsePoses) {
  Make("<ComputeRoute start_id=\"3\" goal_id=\"65535\" goal=\"4;0;0\"/>");
  EXPECT_EQ(Next(), "R ");
  EXPECT_EQ(robot.Take(), "route 3 to 65535; ");
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  EXPECT_EQ(robot.Take(), "route! ") << "a halt cancels it";
}
TEST_F(AComputeRoute, WithoutAGoalIsAFaultOfTheTree) {
  Make("<ComputeRoute use_poses=\"true\"/>");
  Next();
  EXPECT_THAT(fault, HasSubstr("goal"));
  EXPECT_EQ(robot.Take(), "");
}

using AComputeAndTrackRoute = Nav2Tree;
TEST_F(AComputeAndTrackRoute, SaysWhereTheRobotIsUntilItsEnd) {
  Make(
      "<ComputeAndTrackRoute start_id=\"1\" goal_id=\"3\" last_node_id=\"{last}\" "
      "next_node_id=\"{next}\" current_edge_id=\"{edge}\" route=\"{route}\" path=\"{path}\" "
      "rerouted=\"{rerouted}\" execution_duration=\"{t}\"/>");
  const auto seen = [this] {
    auto& board = tree->board();
    return std::vector<int>{board.Get<int>("last").value(), board.Get<int>("next").value(),
                            board.Get<int>("edge").value()};
  };
  EXPECT_EQ(Next(), "R ");
  EXPECT_EQ(robot.Take(), "track 1 to 3; ");
  robot.progress = {1, 2, 12, Corner(), Straight(7), false, 1};
  EXPECT_EQ(Next(), "R ");
  EXPECT_THAT(seen(), ElementsAre(1, 2, 12));
  EXPECT_EQ(tree->board().Get<Route>("route").value(), Corner());
  EXPECT_EQ(tree->board().Get<Path>("path").value(), Straight(7));
  EXPECT_FALSE(tree->board().Get<bool>("rerouted").value());
  robot.progress = {2, 4, 24, {}, {}, true, 2};
  EXPECT_EQ(Next(), "R ");
  EXPECT_THAT(seen(), ElementsAre(2, 4, 24));
  EXPECT_TRUE(tree->board().Get<bool>("rerouted").value());
  robot.ends["track"] = {.success = true};
  EXPECT_EQ(Next(), "S ");
  EXPECT_THAT(seen(), ElementsAre(0, 0, 0)) << "it is over";
}

using ACancelComputeAndTrackRoute = Nav2Tree;
TEST_F(ACancelComputeAndTrackRoute, FailsWhereThereIsNoRouteServer) {
  Make("<CancelComputeAndTrackRoute server_name=\"compute_and_track_route\"/>");
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(robot.Take(), "cancel routes; ");
  robot.has_tasks = false;
  EXPECT_EQ(Next(), "F ");
}
TEST_F(ACancelComputeAndTrackRoute, OnARobotWithoutRoutesFails) {
  struct : FakeRobot {
    bool CancelRoutes() override { return Robot::CancelRoutes(); }
  } plain;
  Factory nodes;
  AddNodes(nodes, plain);
  const auto alone = MakeTree(Main("<CancelComputeAndTrackRoute/>"), nodes);
  EXPECT_EQ(Letter(alone->TickOnce(At(0))), 'F');
}

using RouteGoals = Nav2Tree;
TEST_F(RouteGoals, LookAlongTheRoute) {
  Make("<ExtractRouteNodesAsGoals route=\"{route}\" goals=\"{goals}\"/>");
  Put("route", Corner());
  EXPECT_EQ(Next(), "S ");
  const Goals goals{{{.x_m = 0, .y_m = 0, .yaw_rad = 0},
                     {.x_m = 3, .y_m = 0, .yaw_rad = M_PI / 2},
                     {.x_m = 3, .y_m = 4, .yaw_rad = M_PI / 2}}};
  EXPECT_EQ(tree->board().Get<Goals>("goals").value(), goals);
  Put("route", Route{});
  EXPECT_EQ(Next(), "F ");
}

using ASmoothPath = Nav2Tree;
TEST_F(ASmoothPath, GivesThePathAndWhetherItWasCompleted) {
  Make(
      "<SmoothPath unsmoothed_path=\"{raw}\" smoothed_path=\"{path}\" smoother_id=\"route\" "
      "check_for_collisions=\"true\" max_smoothing_duration=\"3\" was_completed=\"{done}\" "
      "smoothing_duration=\"{t}\" error_code_id=\"{code}\" error_msg=\"{why}\"/>");
  Put("raw", Straight(4));
  robot.ends["smooth"] = {.success = true, .path = Straight(3.9)};
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(robot.Take(), "smooth 4 m by route, checked; ");
  EXPECT_EQ(tree->board().Get<Path>("path").value(), Straight(3.9));
  EXPECT_TRUE(tree->board().Get<bool>("done").value());
  robot.ends["smooth"] = {.error_code = kSmoothedPathInCollision, .error = "a box"};
  EXPECT_EQ(Next(), "F ");
  EXPECT_EQ(tree->board().Get<Path>("path").value(), Path{});
  EXPECT_FALSE(tree->board().Get<bool>("done").value());
  EXPECT_EQ(tree->board().Get<int>("code").value(), 503);
}

using RouteRecoveries = Nav2Tree;
TEST_F(RouteRecoveries, HelpByTheCodesThatAreDocumented) {
  const auto helps = [this](const std::string& node, int code) {
    Make("<" + node + " error_code=\"" + std::to_string(code) + "\"/>");
    return Next() == "S ";
  };
  for (int code = 399; code < 409; ++code) {
    EXPECT_EQ(helps("WouldARouteRecoveryHelp", code), code == 400 || code == 404 || code == 405)
        << code;
  }
  for (int code = 499; code < 507; ++code) {
    EXPECT_EQ(helps("WouldASmootherRecoveryHelp", code),
              code == 500 || code == 502 || code == 503 || code == 504)
        << code;
  }
}

}  // namespace musher::tree::nav2::routes_test
