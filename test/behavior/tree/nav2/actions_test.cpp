// The actions of nav2 on a robot that a test scripts, and a whole tree of the shape of nav2's own.

#include "musher/test/behavior/tree/nav2/fake_robot.hpp"

namespace musher::tree::nav2::actions_test {

using testing::HasSubstr;

using AComputePathToPose = Nav2Tree;
TEST_F(AComputePathToPose, GivesThePathAndTheCode) {
  Make(
      "<ComputePathToPose goal=\"{goal}\" start=\"{start}\" path=\"{path}\" planner_id=\"grid\" "
      "error_code_id=\"{code}\" error_msg=\"{why}\" server_name=\"x\" server_timeout=\"10\"/>");
  Put("goal", Pose{.x_m = 4});
  EXPECT_EQ(Next(), "R ");
  EXPECT_EQ(robot.Take(), "plan to 4 by grid; ");
  robot.ends["plan"] = {.success = true, .path = Straight(4)};
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(tree->board().Get<Path>("path").value(), Straight(4));
  EXPECT_EQ(tree->board().Get<int>("code").value(), 0);
  Put("start", Pose{.x_m = 1});
  robot.ends["plan"] = {.error_code = kNoValidPath, .error = "walled in", .path = Straight(9)};
  EXPECT_EQ(Next(), "F ");
  EXPECT_EQ(robot.Take(), "plan to 4 from 1 by grid; ");
  EXPECT_EQ(tree->board().Get<Path>("path").value(), Path{});
  EXPECT_EQ(tree->board().Get<int>("code").value(), 208);
  EXPECT_EQ(tree->board().Get<std::string>("why").value(), "walled in");
}
TEST_F(AComputePathToPose, PlansFromTheRobotWhereUseStartIsFalse) {
  Make("<ComputePathToPose goal=\"1;2;0\" start=\"5;0;0\" use_start=\"false\"/>");
  EXPECT_EQ(Next(), "R ");
  EXPECT_EQ(robot.Take(), "plan to 1; ");
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  EXPECT_EQ(robot.Take(), "plan! ") << "a halt cancels it";
}

TEST_F(AComputePathToPose, LeavesNoCodeAndNoPathWhenItIsHalted) {
  Make(
      "<ComputePathToPose goal=\"1;0;0\" path=\"{path}\" error_code_id=\"{code}\" "
      "error_msg=\"{why}\"/>");
  Put("path", Straight(3));
  Put("code", std::uint16_t{206});
  Put("why", std::string("occupied"));
  EXPECT_EQ(Next(), "R ");
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  EXPECT_EQ(tree->board().Get<int>("code").value(), 0);
  EXPECT_EQ(tree->board().Get<std::string>("why").value(), "");
  EXPECT_EQ(tree->board().Get<Path>("path").value(), Path{});
}
TEST_F(AComputePathToPose, LeavesNoCodeToTheNextRunOfTheTree) {
  Make("<Sequence>" + SayXml("a", "SR") +
       "<ComputePathToPose goal=\"1;0;0\" error_code_id=\"{code}\" error_msg=\"{why}\"/>"
       "</Sequence>");
  robot.ends["plan"] = {.error_code = kNoValidPath, .error = "walled in"};
  EXPECT_EQ(Next(), "F a^ ");
  EXPECT_EQ(tree->board().Get<int>("code").value(), 208) << "the program may read it";
  EXPECT_EQ(Next(), "R a^ ");
  EXPECT_EQ(tree->board().Get<int>("code").value(), 0);
  EXPECT_EQ(tree->board().Get<std::string>("why").value(), "");
}

using AFollowPath = Nav2Tree;
TEST_F(AFollowPath, TakesANewerControllerWithoutAStop) {
  Make("<FollowPath path=\"{path}\" controller_id=\"{by}\"/>");
  Put("path", Straight(4));
  Put("by", std::string("dwb"));
  EXPECT_EQ(Next(), "R ");
  Put("path", Path{});
  Put("by", std::string("mppi"));
  EXPECT_EQ(NextTicks(2), "R \nR \n");
  EXPECT_EQ(robot.Take(), "follow 4 m by dwb; follow 4 m by mppi; follow! ");
}
TEST_F(AFollowPath, GoesOnForAnotherNameWhereTheRobotHasOneController) {
  robot.has_controllers = false;
  Make("<FollowPath path=\"{path}\" controller_id=\"{by}\"/>");
  Put("path", Straight(4));
  Put("by", std::string("dwb"));
  EXPECT_EQ(Next(), "R ");
  Put("by", std::string("mppi"));
  EXPECT_EQ(NextTicks(2), "R \nR \n");
  EXPECT_EQ(robot.Take(), "follow 4 m by dwb; ");
}
TEST_F(AFollowPath, TakesANewerPathWithoutAStop) {
  Make("<FollowPath path=\"{path}\" controller_id=\"dwb\"/>");
  Put("path", Straight(4));
  EXPECT_EQ(Next(), "R ");
  Put("path", Straight(4));
  EXPECT_EQ(Next(), "R ") << "the same again";
  EXPECT_EQ(robot.Take(), "follow 4 m by dwb; ");
  Put("path", Straight(3));
  EXPECT_EQ(Next(), "R ");
  EXPECT_EQ(robot.Take(), "follow 3 m by dwb; follow! ") << "the new one begins first";
  Put("path", Path{});
  EXPECT_EQ(Next(), "R ") << "no path was found: the one before counts";
  EXPECT_EQ(robot.Take(), "");
  robot.ends["follow"] = {.success = true};
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(robot.Take(), "");
}

using Motions = Nav2Tree;
TEST_F(Motions, HaveTheAmountsOfTheirPorts) {
  Make(
      "<Sequence><Spin spin_dist=\"-1.57\" is_recovery=\"true\"/>"
      "<BackUp backup_dist=\"-0.3\" backup_speed=\"0.05\"/>"
      "<BackUp backup_dist=\"0.3\" backup_speed=\"0.05\" time_allowance=\"4\"/>"
      "<DriveOnHeading dist_to_travel=\"0.2\" speed=\"0.02\" time_allowance=\"100\"/>"
      "<ClearEntireCostmap service_name=\"global\"/><Spin/><BackUp/></Sequence>");
  for (const char* task : {"spin", "drive", "clear"}) robot.ends[task] = {.success = true};
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(
      robot.Take(),
      "spin -1.57 in 10; drive -0.3 at 0.05 in 10; drive -0.3 at 0.05 in 4; "
      "drive 0.2 at 0.02 in 100; clear global; spin 1.57 in 10; drive -0.15 at 0.025 in 10; ");
}
TEST_F(Motions, FailWhereTheRobotHasNone) {
  robot.has_tasks = false;
  Make("<Spin error_msg=\"{why}\"/>");
  EXPECT_EQ(Next(), "F ");
  EXPECT_EQ(tree->board().Get<std::string>("why").value(), "the robot does not have this action");
}
TEST_F(Motions, AreCancelledWhereTheirConditionThrows) {
  Make("<Spin _while=\"distance &gt; 1\"/>");
  Put("distance", 2);
  EXPECT_EQ(Next(), "R ");
  EXPECT_EQ(robot.Take(), "spin 1.57 in 10; ");
  ASSERT_TRUE(tree->board().Set("distance", "far"));
  EXPECT_EQ(Next(), "! ");
  EXPECT_EQ(robot.Take(), "spin! ");
}
TEST_F(Motions, AreCancelledWhereTheirTaskThrows) {
  Make("<Spin/>");
  robot.polls_throw = true;
  EXPECT_EQ(Next(), "! ");
  EXPECT_EQ(robot.Take(), "spin 1.57 in 10; spin! ") << "when it starts";
  robot.polls_throw = false;
  EXPECT_EQ(Next(), "R ");
  robot.polls_throw = true;
  EXPECT_EQ(Next(), "! ");
  EXPECT_EQ(robot.Take(), "spin 1.57 in 10; spin! ") << "while it runs";
}
TEST_F(Motions, FailWithACodeWhichIsNeverThatOfASuccess) {
  for (const auto& [node, code] : std::map<std::string, int>{{"Spin", 700},
                                                             {"BackUp", 710},
                                                             {"DriveOnHeading", 720},
                                                             {"ClearEntireCostmap", 1},
                                                             {"FollowPath path=\"{path}\"", 100}}) {
    Make("<" + node + " error_code_id=\"{code}\"/>");
    if (code == 100) Put("path", Straight(1));
    for (const char* task : {"spin", "drive", "clear", "follow"}) robot.ends[task] = {};
    EXPECT_EQ(Next(), "F ");
    EXPECT_EQ(tree->board().Get<int>("code").value(), code) << node;
    robot.has_tasks = false;
    EXPECT_EQ(Next(), "F ");
    EXPECT_EQ(tree->board().Get<int>("code").value(), code) << node;
    robot.has_tasks = true;
  }
}
TEST_F(Motions, HaveTheCodesOfTheirAction) {
  for (const auto& [drive, back_up] :
       std::map<std::uint16_t, int>{{720, 710}, {721, 711}, {722, 712}, {723, 714}, {724, 713}}) {
    robot.ends["drive"] = {.error_code = drive};
    Make("<DriveOnHeading error_code_id=\"{code}\"/>");
    EXPECT_EQ(Next(), "F ");
    EXPECT_EQ(tree->board().Get<int>("code").value(), drive);
    Make("<BackUp error_code_id=\"{code}\"/>");
    EXPECT_EQ(Next(), "F ");
    EXPECT_EQ(tree->board().Get<int>("code").value(), back_up);
  }
}
TEST_F(Motions, DriveOnHeadingRefusesADistanceAndASpeedOfDifferentSigns) {
  for (const std::string ports :
       {"dist_to_travel=\"-0.3\" speed=\"0.1\"", "dist_to_travel=\"0.3\" speed=\"-0.1\""}) {
    Make("<DriveOnHeading " + ports + " error_code_id=\"{code}\"/>");
    EXPECT_EQ(Next(), "F ");
    EXPECT_EQ(tree->board().Get<int>("code").value(), 724);
  }
  EXPECT_EQ(robot.Take(), "");
  Make("<DriveOnHeading dist_to_travel=\"-0.3\" speed=\"-0.1\"/>");
  EXPECT_EQ(Next(), "R ");
  EXPECT_EQ(robot.Take(), "drive -0.3 at 0.1 in 10; ");
}
TEST_F(Motions, AreWarnedOfWhereTheirLimitIsTooShortForTheRobot) {
  robot.most_turn = 0.6;
  robot.most_drive = 0.15;
  EXPECT_EQ(Findings(Main("<Spin spin_dist=\"6.28\"/>"), factory),
            "t.xml:3:1: warning: Spin takes 10.5 s on this robot, and fails after 10 s\n");
  EXPECT_EQ(Findings(Main("<DriveOnHeading dist_to_travel=\"1.2\" speed=\"0.3\" "
                          "time_allowance=\"5\"/>"),
                     factory),
            "t.xml:3:66: warning: DriveOnHeading takes 8 s on this robot, and fails after 5 s\n");
  EXPECT_EQ(Findings(Main("<Sequence><Spin spin_dist=\"6.28\" time_allowance=\"0\"/>"
                          "<Spin spin_dist=\"{far}\"/><BackUp/></Sequence>"),
                     factory),
            "");
}
TEST_F(Motions, AreWarnedOfWhereTwoMayRunTogether) {
  const std::string two = "<BackUp/>\n<Inverter><FollowPath path=\"{path}\"/></Inverter>";
  EXPECT_EQ(Findings(Main("<Parallel>" + two + "</Parallel>"), factory),
            "t.xml:4:1: warning: 'BackUp' and 'Inverter' both use the base, which only one of them "
            "can have at a time, and Parallel may run them together\n");
  EXPECT_THAT(Findings(Main("<ParallelAll>" + two + "</ParallelAll>"), factory),
              HasSubstr("warning: 'BackUp' and 'Inverter' both use the base"));
  EXPECT_THAT(Findings(Main("<PipelineSequence>" + two + "</PipelineSequence>"), factory),
              HasSubstr("warning: 'BackUp' and 'Inverter' both use the base, which only one of "
                        "them can have at a time, and PipelineSequence may run them together"));
  EXPECT_THAT(Findings(Main("<NonblockingSequence>" + two + "</NonblockingSequence>"), factory),
              HasSubstr("and NonblockingSequence may run them together"));
  EXPECT_EQ(Findings(Main("<Sequence>" + two + "<Parallel><DriveOnHeading/><Wait/></Parallel>" +
                          "<Fallback><Spin/><Spin/></Fallback></Sequence>"),
                     factory),
            "");
}
TEST_F(Motions, RefuseALimitThatIsNoTimeAndADistanceThatIsNone) {
  for (const char* amount : {"nan", "1e9", "-inf"}) {
    Make("<BackUp backup_dist=\"" + std::string(amount) + "\"/>");
    EXPECT_EQ(Next(), "! ");
    EXPECT_THAT(fault, HasSubstr("port 'backup_dist' has to be from -100 to 100"));
  }
  Make("<Spin time_allowance=\"-1\"/>");
  EXPECT_EQ(Next(), "! ");
  EXPECT_THAT(fault, HasSubstr("port 'time_allowance' has to be from 0 to 1e6 s"));
}
TEST_F(Motions, WaitForItsTime) {
  Make("<Wait wait_duration=\"0.5\" error_code_id=\"{code}\"/>");
  EXPECT_EQ(TickAt(100), "R ");
  EXPECT_EQ(TickAt(599), "R ");
  EXPECT_EQ(TickAt(600), "S ");
  EXPECT_EQ(TickAt(700), "R ");
}

using Selectors = Nav2Tree;
TEST_F(Selectors, GiveWhatWasSelectedOrElseTheDefault) {
  Make("<PlannerSelector selected_planner=\"{p}\" default_planner=\"grid\" topic_name=\"t\"/>");
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(tree->board().Get<std::string>("p").value(), "grid");
  robot.selected["t"] = "theta";
  EXPECT_EQ(Next(), "S ");
  EXPECT_EQ(tree->board().Get<std::string>("p").value(), "theta");
  Make("<ControllerSelector selected_controller=\"{c}\"/>");
  EXPECT_EQ(Next(), "F ");
  robot.selected["controller_selector"] = "dwb";
  EXPECT_EQ(Next(), "S ");
}

// Plans once a second and follows the path; each has a recovery of its own, and all recoveries
// stand in a RoundRobin that a new goal ends.
const std::string kNavigation =
    "<RecoveryNode number_of_retries=\"6\"><PipelineSequence>"
    "<PlannerSelector selected_planner=\"{planner}\" default_planner=\"grid\"/>"
    "<RateController hz=\"1\"><RecoveryNode number_of_retries=\"1\">"
    "<ComputePathToPose goal=\"{goal}\" path=\"{path}\" planner_id=\"{planner}\" "
    "error_code_id=\"{plan_code}\"/>"
    "<Sequence><WouldAPlannerRecoveryHelp error_code=\"{plan_code}\"/>"
    "<ClearEntireCostmap service_name=\"global\"/></Sequence></RecoveryNode></RateController>"
    "<RecoveryNode number_of_retries=\"1\">"
    "<FollowPath path=\"{path}\" error_code_id=\"{follow_code}\"/>"
    "<Sequence><WouldAControllerRecoveryHelp error_code=\"{follow_code}\"/>"
    "<ClearEntireCostmap service_name=\"local\"/></Sequence></RecoveryNode></PipelineSequence>"
    "<Sequence><Fallback><WouldAControllerRecoveryHelp error_code=\"{follow_code}\"/>"
    "<WouldAPlannerRecoveryHelp error_code=\"{plan_code}\"/></Fallback>"
    "<ReactiveFallback><GoalUpdated/><RoundRobin>"
    "<Sequence><ClearEntireCostmap service_name=\"local\"/>"
    "<ClearEntireCostmap service_name=\"global\"/></Sequence>"
    "<Spin/><Wait wait_duration=\"5\"/><BackUp backup_dist=\"0.3\" backup_speed=\"0.05\"/>"
    "</RoundRobin></ReactiveFallback></Sequence></RecoveryNode>";

struct ANavigation : Nav2Tree {
  ANavigation() {
    Make(kNavigation);
    EXPECT_TRUE(tree->board().Set("goal", Pose{.x_m = 9}));
    robot.ends["plan"] = {.success = true, .path = Straight(9)};
    robot.ends["clear"] = {.success = true};
  }
};
TEST_F(ANavigation, PlansOnceASecondAndFollows) {
  EXPECT_EQ(TickAt(0), "R ");
  EXPECT_EQ(robot.Take(), "plan to 9 by grid; follow 9 m; ");
  EXPECT_EQ(TickAt(990), "R ");
  EXPECT_EQ(robot.Take(), "");
  robot.ends["plan"].path = Straight(8);
  EXPECT_EQ(TickAt(1000), "R ");
  EXPECT_EQ(robot.Take(), "plan to 9 by grid; follow 8 m; follow! ");
  robot.ends["follow"] = {.success = true};
  EXPECT_EQ(TickAt(1100), "S ");
}
TEST_F(ANavigation, RecoversStepByStepAndEndsARecoveryForANewGoal) {
  robot.ends["follow"] = {.error_code = kPatienceExceeded};
  EXPECT_EQ(TickAt(0), "R ");
  EXPECT_EQ(robot.Take(),
            "plan to 9 by grid; follow 9 m; clear local; follow 9 m; "  // its own recovery
            "clear local; clear global; "                               // the first of all
            "plan to 9 by grid; follow 9 m; clear local; follow 9 m; "
            "spin 1.57 in 10; ");
  EXPECT_EQ(TickAt(100), "R ");
  Put("goal", Pose{.x_m = 5});
  EXPECT_EQ(TickAt(200), "R ") << "a new attempt, and the first recovery: it was halted";
  EXPECT_EQ(robot.Take(),
            "spin! plan to 5 by grid; follow 9 m; clear local; follow 9 m; clear local; "
            "clear global; plan to 5 by grid; follow 9 m; clear local; follow 9 m; "
            "spin 1.57 in 10; ");
}
TEST_F(ANavigation, GivesUpWhereNoRecoveryHelps) {
  robot.ends["plan"] = {.error_code = 204};  // the goal is outside the map
  EXPECT_EQ(TickAt(0), "F ");
  EXPECT_EQ(robot.Take(), "plan to 9 by grid; ");
}

}  // namespace musher::tree::nav2::actions_test
