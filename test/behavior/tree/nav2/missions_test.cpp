// The missions of nav2, the nodes that cancel others, and the checks of places, on a robot that a
// test scripts.

#include "musher/test/behavior/tree/nav2/fake_robot.hpp"

namespace musher::tree::nav2::missions_test {

using testing::HasSubstr;

using Missions = Nav2Tree;
TEST_F(Missions, NavigateToPoseSendsTheRobotToItsGoal) {
  Make(
      "<NavigateToPose goal=\"{goal}\" behavior_tree=\"x.xml\" server_name=\"s\" "
      "error_code_id=\"{code}\" error_msg=\"{why}\"/>");
  Put("goal", Pose{.x_m = 3});
  EXPECT_EQ(Next(), "R ");
  EXPECT_EQ(robot.Take(), "navigate 3; ");
  robot.ends["navigate"] = {.error = "walled in"};
  EXPECT_EQ(Next(), "F ");
  EXPECT_EQ(tree->board().Get<int>("code").value(), 9000);
  EXPECT_EQ(tree->board().Get<std::string>("why").value(), "walled in");
  robot.ends["navigate"] = {.success = true};
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(tree->board().Get<int>("code").value(), 0);
}
TEST_F(Missions, NavigateThroughPosesSendsItToEach) {
  Make("<NavigateThroughPoses goals=\"{goals}\" error_code_id=\"{code}\" error_msg=\"{why}\"/>");
  Put("goals", Goals{{Pose{.x_m = 3}, Pose{.x_m = 1}}});
  EXPECT_EQ(Next(), "R ");
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  EXPECT_EQ(robot.Take(), "navigate 3 1; navigate! ");
  Put("goals", Goals{});
  EXPECT_EQ(Next(), "F ");
  EXPECT_EQ(tree->board().Get<int>("code").value(), 9100);
  EXPECT_EQ(tree->board().Get<std::string>("why").value(), "there are no places");
}
TEST_F(Missions, HaveTheTopicAndTheTimeOfTheirPorts) {
  Make(
      "<Sequence><FollowObject/><FollowObject pose_topic=\"/person\" max_duration=\"20\" "
      "tracked_frame=\"p\"/><AssistedTeleop/><AssistedTeleop time_allowance=\"0\" "
      "is_recovery=\"true\"/></Sequence>");
  for (const char* task : {"object", "teleop"}) robot.ends[task] = {.success = true};
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(robot.Take(),
            "object dynamic_pose for 0; object /person for 20; teleop 10; teleop 0; ");
  Make("<AssistedTeleop time_allowance=\"-1\"/>");
  EXPECT_EQ(Next(), "! ");
}
TEST_F(Missions, UseTheBase) {
  EXPECT_THAT(
      Findings(Main("<Parallel><NavigateToPose goal=\"1;0;0\"/><Spin/></Parallel>"), factory),
      HasSubstr("both use the base"));
}

using ACancel = Nav2Tree;
TEST_F(ACancel, EndsTheNodesOfItsKindInTheirNextTick) {
  struct Case {
    std::string kind;
    std::string ports;
    std::string begins;
    std::string cancelled;
    int code;
  };
  for (const Case& each :
       std::vector<Case>{{"Spin", "", "spin 1.57 in 10; ", "spin! ", 700},
                         {"BackUp", "", "drive -0.15 at 0.025 in 10; ", "drive! ", 710},
                         {"DriveOnHeading", "", "drive 0.15 at 0.025 in 10; ", "drive! ", 720},
                         {"AssistedTeleop", "", "teleop 10; ", "teleop! ", 730},
                         {"Wait", "wait_duration=\"100\"", "", "", 740},
                         {"FollowObject", "", "object dynamic_pose for 0; ", "object! ", 1000}}) {
    Make("<ParallelAll><" + each.kind + " " + each.ports +
         " error_code_id=\"{code}\" error_msg=\"{why}\"/><Sequence>" + SayXml("a", "RRS") +
         "<Cancel" + each.kind + " server_name=\"x\"/></Sequence></ParallelAll>");
    EXPECT_EQ(NextTicks(3), "R a^ \nR a \nR a \n") << each.kind;
    EXPECT_EQ(robot.Take(), each.begins) << each.kind;
    EXPECT_EQ(Next(), "F ") << each.kind;
    EXPECT_EQ(robot.Take(), each.cancelled) << each.kind;
    EXPECT_EQ(tree->board().Get<int>("code").value(), each.code) << each.kind;
    EXPECT_EQ(tree->board().Get<std::string>("why").value(), "a node of a tree has cancelled it");
  }
}
TEST_F(ACancel, EndsNoOtherNodeAndNoneThatBeginsLater) {
  Make("<Sequence><CancelSpin/><CancelWait/><CancelDriveOnHeading/><BackUp/><Spin/></Sequence>");
  EXPECT_EQ(NextTicks(2), "R \nR \n");
  robot.CancelNodes(Cancellable::kDriveOnHeading);
  EXPECT_EQ(Next(), "R ");
  robot.ends["drive"] = {.success = true};
  EXPECT_EQ(NextTicks(2), "R \nR \n");
  EXPECT_EQ(robot.Take(), "drive -0.15 at 0.025 in 10; spin 1.57 in 10; ");
}
TEST_F(ACancel, EndsTheNodesOfAnotherTreeToo) {
  Make("<Spin/>");
  EXPECT_EQ(Next(), "R ");
  const auto other = MakeTree(Main("<CancelSpin/>"), factory);
  EXPECT_EQ(Letter(other->TickOnce(At(now_ms))), 'S');
  EXPECT_EQ(Next(), "F ");
}

using APlace = Nav2Tree;
TEST_F(APlace, IsOccupiedWhereTheRobotSaysSoOrDoesNotKnow) {
  for (const std::string node : {"CheckPoseOccupancy", "IsPoseOccupied"}) {
    Make("<" + node + " pose=\"{at}\" error_msg=\"{why}\" service_name=\"x\"/>");
    Put("at", Pose{.x_m = 2});
    robot.ends.clear();
    EXPECT_EQ(Next(), "R ");
    EXPECT_EQ(robot.Take(), "check 2; ");
    robot.ends["check"] = {.success = true, .occupied = {true}};
    EXPECT_EQ(Next(), "S ");
    robot.ends["check"] = {.success = true, .occupied = {false}};
    EXPECT_EQ(Next(), "F ");
    robot.ends["check"] = {.error = "no map has come"};
    EXPECT_EQ(Next(), "S ");
    EXPECT_EQ(tree->board().Get<std::string>("why").value(), "no map has come");
    robot.Take();
  }
}
TEST_F(APlace, IsCheckedForTheWholeBodyUnlessTheTreeSaysSo) {
  robot.ends["check"] = {.success = true, .occupied = {false}};
  const std::string exactly = "use_footprint=\"false\"";
  const std::string unknown = "consider_unknown_as_obstacle=\"true\"";
  for (const auto& [ports, how] :
       std::map<std::string, std::string>{{exactly, " exactly"},
                                          {exactly + " cost_threshold=\"253\"", ""},
                                          {unknown, ", unknown too"}}) {
    Make("<CheckPoseOccupancy pose=\"2;0;0\" " + ports + "/>");
    EXPECT_EQ(Next(), "F ");
    EXPECT_EQ(robot.Take(), "check 2" + how + "; ");
  }
}
TEST_F(APlace, ThatIsOccupiedIsRemovedFromTheGoals) {
  Make(
      "<RemoveInCollisionGoals input_goals=\"{goals}\" output_goals=\"{goals}\" "
      "input_waypoint_statuses=\"{s}\" output_waypoint_statuses=\"{s}\"/>");
  const Goals all{{Pose{.x_m = 1}, Pose{.x_m = 2}, Pose{.x_m = 3}}};
  Put("goals", all);
  robot.ends["check"] = {.error = "no map has come"};
  EXPECT_EQ(Next(), "F ");
  EXPECT_EQ(tree->board().Get<Goals>("goals").value(), all) << "that it does not know";
  robot.ends["check"] = {.success = true, .occupied = {false, true, false}};
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(tree->board().Get<Goals>("goals").value(), (Goals{{Pose{.x_m = 1}, Pose{.x_m = 3}}}));
}

}  // namespace musher::tree::nav2::missions_test
