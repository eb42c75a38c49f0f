// navigate_to, nav_2d and nav_3d: texts, limits, faults, cancel and pause.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "musher/test/modules/skills/moving_robot.hpp"

namespace musher::navigate_to_test {

using skill::Status;
using skills::testing::SkillsOnARobot;
using ::testing::AllOf;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::Le;
using ::testing::MatchesRegex;
using ::testing::StartsWith;

using Texts = std::vector<std::pair<std::string, std::string>>;

class NavigateTo : public ::testing::Test, public SkillsOnARobot {
 protected:
  void Go(const Texts& parameters = {{"goal_pos", "[4, 3, 0]"}}) {
    const Result<> started = Start("navigate_to", parameters);
    ASSERT_TRUE(started) << started.error().message;
  }
  void ExpectFailure(double seconds, const std::string& message) {
    EXPECT_TRUE(RunToItsEnd(seconds)) << feedback().state;
    EXPECT_EQ(feedback().status, Status::kFailed);
    EXPECT_THAT(message_of_end(), HasSubstr(message));
    ExpectRest();
  }
  std::string message_of_end() const { return feedback().message; }
  void ExpectRest() {
    for (int i = 0; i < 20; ++i) robot.Advance(Milliseconds(100));
    EXPECT_TRUE(robot.Rests());
  }
  void ExpectRefusal(const Texts& parameters, const std::string& message) {
    Go(parameters);
    ExpectFailure(1, message);
    EXPECT_EQ(robot.plans, 0);
    static_cast<void>(manager->Reset("navigate_to").ok());
  }
};

TEST_F(NavigateTo, DoesNotTakeADriveForArrivedWhoseEndHasNoPose) {
  Go();
  RunFor(3);
  ASSERT_TRUE(robot.driving());
  robot.odometry_up = false;
  robot.EndDrive();
  Step();
  robot.odometry_up = true;
  EXPECT_TRUE(RunToItsEnd(60));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_NEAR(robot.at.at.x_m, 4, 0.2);
}

// The planner refuses a start that is nearer than 0.35 m to the wall at x = -0.3.
TEST_F(NavigateTo, LeavesATightStartAndGoesOn) {
  for (const double yaw_rad : {0.0, 1.5, 3.0, -2.0}) {
    robot.at = {{0, 0, 0}, yaw_rad};
    robot.points.clear();
    for (int i = -20; i <= 20; ++i) robot.points.push_back({-0.25, 0.05 * i, 0});
    robot.plan = [](const navigation::Pose& start,
                    const navigation::Pose& goal) -> Result<navigation::Path> {
      if (start.at.x_m > 0.1) return navigation::Path{start, goal};
      return navigation::MakeError(navigation::Fault::kStartBlocked, "the start has no room");
    };
    robot.nearest_m = 1;
    Go();
    EXPECT_TRUE(RunToState("RECOVERING", 5));
    Step();
    EXPECT_EQ(feedback().message, "No room to start: leave_tight_start");
    EXPECT_TRUE(RunToItsEnd(60));
    EXPECT_EQ(feedback().status, Status::kCompleted) << yaw_rad << ": " << feedback().message;
    EXPECT_GT(robot.nearest_m, robot.radius_m()) << yaw_rad;
  }
}

TEST_F(NavigateTo, FailsWithTheReasonOnceItsRecoveriesAreUsedUp) {
  robot.plan = [](const auto&, const auto&) -> Result<navigation::Path> {
    return navigation::MakeError(navigation::Fault::kStartBlocked, "the start has no room");
  };
  robot.points = {{-0.3, 0, 0}};
  std::set<std::string> texts;
  EachStep([&] { texts.insert(feedback().message); });
  Go();
  ExpectFailure(60, "Planning failed: the start has no room");
  for (const char* name : {"leave_tight_start", "clear", "wait", "back_up", "spin"}) {
    EXPECT_TRUE(texts.contains("No room to start: " + std::string(name))) << name;
  }
  EXPECT_EQ(robot.plans, 6);
  Go({{"goal_pos", "[4, 3, 0]"}, {"recoveries", ""}});
  ExpectFailure(2, "the start has no room");
}

TEST_F(NavigateTo, WaitsForALostScanOrOdometryAndGoesOn) {
  for (const auto fault : {navigation::Fault::kScan, navigation::Fault::kOdometry}) {
    robot.at = {};
    Go();
    RunFor(2);
    robot.FailDrive(navigation::MakeError(fault, "its scan is lost"));
    Step();
    EXPECT_EQ(feedback().state, "INITIALIZING");
    EXPECT_TRUE(RunToItsEnd(30));
    EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  }
}

TEST_F(NavigateTo, ReportsEachPhaseWithItsTextAndProgress) {
  std::set<std::string> texts;
  Go();
  EachStep([&] {
    texts.insert(feedback().message.substr(0, 17) + " " + std::to_string(feedback().progress));
  });
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().status, Status::kCompleted);
  EXPECT_EQ(feedback().message, "Reached goal");
  EXPECT_EQ(feedback().progress, 100);
  EXPECT_NEAR(robot.at.at.x_m, 4, 0.2);
  EXPECT_NEAR(robot.at.at.y_m, 3, 0.2);
  EXPECT_THAT(texts, IsSupersetOf({"Sending request.. 5", "Planning path... 15",
                                   "Planning path... 30", "Reached goal 100"}));
}

TEST_F(NavigateTo, ReportsDistanceVelocityAndTimeWhileItMoves) {
  Go();
  ASSERT_TRUE(RunToState("EXECUTING"));
  RunFor(2);
  EXPECT_THAT(feedback().message, MatchesRegex("Moving\\.\\.\\. \\([0-9.]+s\\)"));
  EXPECT_THAT(feedback().progress, AllOf(Ge(50), Le(95)));
  EXPECT_NEAR(feedback().details.Number("distance_to_goal"), 3.2, 0.4);
  EXPECT_NEAR(feedback().details.Number("current_velocity"), 1, 0.01);
  EXPECT_NEAR(feedback().details.Number("estimated_time"), 3.6, 0.8);
}

TEST_F(NavigateTo, CountsItsTimeFromItsBeginAlsoWhenTheClockIsLate) {
  now = Time(std::chrono::hours(3));
  Go();
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().status, Status::kCompleted);
}

TEST_F(NavigateTo, TakesTheDirectionOfAQuaternionOfAnyLength) {
  Go({{"goal_pos", "[1, 0]"}, {"goal_quat_wxyz", "[2, 0, 0, 2]"}});
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_NEAR(robot.at.yaw_rad, M_PI / 2, 1e-6);
}

TEST_F(NavigateTo, RefusesAGoalThatIsNone) {
  ExpectRefusal({{"goal_pos", "[1]"}}, "goal_pos has 1 number; expected 2 or 3: x, y and z");
  ExpectRefusal({{"goal_pos", "[1, 2, 3, 4]"}}, "goal_pos has 4 numbers");
  ExpectRefusal({{"goal_pos", "[1, 2]"}, {"goal_quat_wxyz", "[0, 0, 0, 0]"}},
                "goal_quat_wxyz has the length 0");
  ExpectRefusal({{"goal_pos", "[1, 2]"}, {"goal_quat_wxyz", "[1, 0]"}}, "expected 4: w, x, y, z");
  ExpectRefusal({{"goal_pos", "[1, 2]"}, {"start_quat", "[1, 0, 0, 0]"}}, "without start_pos");
  robot.robot_kind = "cf2x";
  ExpectRefusal({{"goal_pos", "[1, 2]"}}, "expected 3: x, y and z");
  ExpectRefusal({{"goal_pos", "[1, 2, -1]"}}, "Invalid altitude: goal_pos is at -1.00 m");
  ExpectRefusal({{"goal_pos", "[1, 2, 1]"}},
                "Invalid altitude: robot_0 is at 0.00 m; it has to take off first");
  robot.ceiling = 2.2;
  ExpectRefusal({{"goal_pos", "[1, 2, 5]"}},
                "goal_pos is at 5.00 m; expected at most 2.20 m, the ceiling of robot_0");
}

TEST_F(NavigateTo, CannotBeginWithoutAGoalOrWithNumbersThatAreNotFinite) {
  EXPECT_FALSE(Start("navigate_to"));
  EXPECT_FALSE(Start("navigate_to", {{"goal_pos", "[nan, 0, 0]"}}));
  EXPECT_FALSE(Start("navigate_to", {{"goal_pos", "[inf, 0, 0]"}}));
  EXPECT_FALSE(Start("navigate_to", {{"goal_pos", "somewhere"}}));
}

TEST_F(NavigateTo, HasAVariantForTheGroundAndOneForTheAir) {
  ASSERT_TRUE(Start("nav_3d", {{"goal_pos", "[1, 0, 1]"}}));
  ExpectFailure(1, "robot_0 does not fly; nav_3d is for flyers, use nav_2d");
  ASSERT_TRUE(Start("nav_2d", {{"goal_pos", "[1, 0, 9]"}, {"ground_height", "0.5"}}));
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().status, Status::kCompleted);
  EXPECT_EQ(robot.at.at.z_m, 0.5);
  robot.robot_kind = "cf2x";
  ASSERT_TRUE(Start("nav_2d", {{"goal_pos", "[1, 0]"}}));
  ExpectFailure(1, "robot_0 flies; nav_2d is for robots on the ground, use nav_3d");
  ASSERT_TRUE(Start("nav_3d", {{"goal_pos", "[3, 0, 2]"}}));
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().status, Status::kCompleted);
  EXPECT_EQ(robot.at.at.z_m, 2);
}

TEST_F(NavigateTo, PlansFromTheStartThatIsGivenAndOnlyOnce) {
  std::vector<navigation::Pose> starts;
  robot.plan = [&](const navigation::Pose& start,
                   const navigation::Pose& goal) -> Result<navigation::Path> {
    starts.push_back(start);
    return navigation::Path{start, goal};
  };
  Go({{"goal_pos", "[4, 0]"}, {"start_pos", "[1, 1]"}, {"start_quat", "[1, 0, 0, 1]"}});
  ASSERT_TRUE(RunToState("EXECUTING"));
  RunFor(1);
  robot.FailDrive(MakeError(navigation::Fault::kObstacle, "a person stays in the way"));
  EXPECT_TRUE(RunToItsEnd(20));
  ASSERT_EQ(starts.size(), 2U);
  EXPECT_EQ(starts[0].at, (navigation::Point{1, 1, 0}));
  EXPECT_NEAR(starts[0].yaw_rad, M_PI / 2, 1e-9);
  EXPECT_NE(starts[1].at, (navigation::Point{1, 1, 0}));
}

TEST_F(NavigateTo, FailsAfterItsLostLimitWithoutThePartsThatItNeeds) {
  robot.planner_up = false;
  Go();
  RunFor(19.9);
  EXPECT_EQ(feedback().state, "INITIALIZING");
  ExpectFailure(0.4, "Path planner server not available: no planner of robot_0, waited for 20 s");
  robot.planner_up = true;
  robot.controller_up = false;
  const Texts three_s = {{"goal_pos", "[4, 3, 0]"}, {"lost_limit", "3"}};
  Go(three_s);
  ExpectFailure(3.3, "Controller server not available");
  robot.controller_up = true;
  robot.odometry_up = false;
  Go(three_s);
  ExpectFailure(3.3, "No odometry of robot_0");
  robot.planner_up = robot.controller_up = false;
  Go(three_s);
  ExpectFailure(3.3, "ROS not available: robot_0 has no odometry");
  Go({{"goal_pos", "[4, 3, 0]"}, {"lost_limit", "0"}});
  ExpectFailure(0.3, "ROS not available: robot_0 has no odometry");
  Go({{"goal_pos", "[4, 3, 0]"}, {"lost_limit", "-1"}});
  ExpectFailure(0.3, "lost_limit is -1; expected 0 or more seconds");
}

TEST_F(NavigateTo, WaitsForAPlannerThatIsDiscoveredLate) {
  robot.planner_up = false;
  Go();
  RunFor(8);
  EXPECT_THAT(feedback().message,
              MatchesRegex("Waiting \\([78] of 20 s\\): Path planner server not available.*"));
  EXPECT_TRUE(robot.Rests());
  robot.planner_up = true;
  Step();
  Step();
  EXPECT_EQ(feedback().state, "PLANNING");
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().message, "Reached goal");
}

TEST_F(NavigateTo, WaitsForALateMapAtAStandAndSaysSo) {
  const auto plans = robot.plan;
  bool has_map = false;
  robot.plan = [&](const auto& start, const auto& goal) -> Result<navigation::Path> {
    if (!has_map) return Error{kCodeStateInvalid, "there is no map yet, on map"};
    return plans(start, goal);
  };
  Go();
  RunFor(15);
  EXPECT_EQ(feedback().status, Status::kProcessing) << feedback().message;
  EXPECT_THAT(feedback().message, HasSubstr("there is no map yet, on map"));
  EXPECT_TRUE(robot.Rests());
  EXPECT_LE(robot.plans, 8) << "an attempt every 2 s";
  has_map = true;
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().message, "Reached goal");
}

TEST_F(NavigateTo, FailsWithTheNameOfTheMapThatDoesNotCome) {
  robot.plan = [](const auto&, const auto&) -> Result<navigation::Path> {
    return Error{kCodeStateInvalid, "there is no map yet, on map"};
  };
  Go({{"goal_pos", "[4, 3, 0]"}, {"lost_limit", "7"}});
  RunFor(6);
  EXPECT_EQ(feedback().status, Status::kProcessing) << feedback().message;
  ExpectFailure(3, "there is no map yet, on map, waited for 7 s");
  EXPECT_EQ(robot.drives, 0);
}

// Each loss has the whole time: what was lost ten minutes before does not count.
TEST_F(NavigateTo, CountsItsLostLimitFromEachLoss) {
  robot.drive_speed_m_s = 0.1;
  Go({{"goal_pos", "[9, 0, 0]"}, {"lost_limit", "6"}});
  for (int loss = 0; loss < 4; ++loss) {
    ASSERT_TRUE(RunToState("EXECUTING"));
    RunFor(5);
    robot.KillController();
    RunFor(3);
    robot.controller_up = true;
  }
  ASSERT_TRUE(RunToState("EXECUTING"));
  robot.drive_speed_m_s = 1;
  EXPECT_TRUE(RunToItsEnd(30));
  EXPECT_EQ(feedback().message, "Reached goal");
}

TEST_F(NavigateTo, DoesNotCountAPauseAsALoss) {
  robot.planner_up = false;
  Go();
  RunFor(10);
  Pause();
  RunFor(300);
  Resume();
  RunFor(8);
  EXPECT_EQ(feedback().status, Status::kProcessing) << feedback().message;
}

TEST_F(NavigateTo, DoesNotGoOnAfterAPauseInWhichAFlyerWasPutDownOrTaken) {
  robot.robot_kind = "cf2x";
  for (const std::string state : {"PLANNING", "EXECUTING"}) {
    for (const bool put_down : {false, true}) {
      robot.at = {{0, 0, 1}, 0};
      robot.not_held.clear();
      ASSERT_TRUE(Start("nav_3d", {{"goal_pos", "[9, 0, 1]"}}));
      ASSERT_TRUE(RunToState(state));
      Pause();
      RunFor(3);
      if (put_down) {
        robot.at.at.z_m = 0;
      } else {
        robot.not_held = "robot_0 is not held at its place any more: it came 0.50 m lower";
      }
      const int drives = robot.drives;
      Resume();
      EXPECT_TRUE(RunToItsEnd(30)) << state << put_down;
      EXPECT_EQ(feedback().status, Status::kFailed);
      EXPECT_THAT(message(), HasSubstr(put_down ? "it has to take off first" : "0.50 m lower"));
      EXPECT_EQ(robot.drives, drives);
    }
  }
}

TEST_F(NavigateTo, DoesNotGoOnInAnotherProcessFromTheGround) {
  robot.robot_kind = "cf2x";
  robot.at = {{0, 0, 1}, 0};
  ASSERT_TRUE(Start("nav_3d", {{"goal_pos", "[9, 0, 1]"}}));
  ASSERT_TRUE(RunToState("EXECUTING"));
  const auto saved = manager->Save();
  ASSERT_TRUE(saved) << saved.error().message;
  robot.CancelDrive();
  robot.at.at.z_m = 0;
  const int drives = robot.drives;
  manager = std::make_unique<skill::Manager>(registry.All());
  ASSERT_THAT(manager->Restore(saved.value()), ::testing::IsEmpty());
  EXPECT_TRUE(RunToItsEnd(30));
  EXPECT_EQ(feedback().status, Status::kFailed);
  EXPECT_THAT(message(), HasSubstr("it has to take off first"));
  EXPECT_EQ(robot.drives, drives);
}

TEST_F(NavigateTo, FailsWithTheReasonOfThePlanner) {
  robot.plan = [](const auto&, const auto&) -> Result<navigation::Path> {
    return MakeError(navigation::Fault::kGoalBlocked, "the goal is in a wall");
  };
  Go();
  ExpectFailure(3, "Planning failed: the goal is in a wall");
  EXPECT_EQ(robot.drives, 0);
  robot.plan = [](const auto&, const auto&) -> Result<navigation::Path> {
    return Error{kCodeStateInvalid, "it is not Active"};
  };
  Go();
  ExpectFailure(30, "Request rejected: it is not Active");
}

// The planner had restarted before the goal came, and was not Active yet.
TEST_F(NavigateTo, AsksAPlannerThatRejectsAgain) {
  const auto plans = robot.plan;
  robot.plan = [&](const auto& goal, const auto& start) -> Result<navigation::Path> {
    if (robot.plans < 3) return Error{kCodeStateInvalid, "it is not Active"};
    return plans(goal, start);
  };
  Go();
  EXPECT_TRUE(RunToItsEnd(30));
  EXPECT_EQ(feedback().message, "Reached goal");
}

TEST_F(NavigateTo, DoesNotDriveAlongAPathThatIsNone) {
  robot.plan = [](const auto&, const auto&) -> Result<navigation::Path> {
    return navigation::Path{};
  };
  Go();
  ExpectFailure(3, "Planning failed: the path has no points");
  robot.plan = [](const auto& start, const auto&) -> Result<navigation::Path> {
    return navigation::Path{start, {{1, 0, 0}, 0}};
  };
  Go();
  ExpectFailure(3, "Planning failed: the path ends 4.2 m from the goal");
  robot.plan = [](const auto& start, const auto& goal) -> Result<navigation::Path> {
    return navigation::Path{start, {{NAN, 0, 0}, 0}, goal};
  };
  Go();
  ExpectFailure(3, "a point that is not finite");
  EXPECT_EQ(robot.drives, 0);
}

TEST_F(NavigateTo, LimitsPlanningAndMoving) {
  robot.answers = false;
  Go();
  RunFor(14.5);
  EXPECT_EQ(feedback().state, "PLANNING");
  ExpectFailure(1.5, "Planning timeout");
  robot.answers = true;
  robot.drive_speed_m_s = 0.01;
  Go();
  RunFor(119);
  EXPECT_EQ(feedback().state, "EXECUTING");
  ExpectFailure(3, "Navigate timeout");
}

TEST_F(NavigateTo, FailsWhenTheControllerGivesUp) {
  Go();
  ASSERT_TRUE(RunToState("EXECUTING"));
  RunFor(1);
  robot.FailDrive(MakeError(navigation::Fault::kLate, "5 s late"));
  ExpectFailure(1, "Navigate failed: 5 s late");
}

TEST_F(NavigateTo, DoesNotBelieveAnArrivalFarFromTheGoal) {
  Go();
  ASSERT_TRUE(RunToState("EXECUTING"));
  robot.EndDrive();
  ExpectFailure(1, "Navigate failed: the drive has ended 5.0 m from the goal");
}

TEST_F(NavigateTo, PlansAgainWhenAnObstacleStays) {
  Go();
  for (int i = 0; i < 15; ++i) {
    ASSERT_TRUE(RunToState("EXECUTING"));
    RunFor(0.2);
    robot.FailDrive(MakeError(navigation::Fault::kObstacle, "a person stays in the way"));
    Step();
  }
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  EXPECT_EQ(run().replans(), 15);
  EXPECT_EQ(run().retries(), 0);
}

TEST_F(NavigateTo, WaitsForALostPlannerAndGoesOn) {
  Go();
  ASSERT_TRUE(RunToState("PLANNING"));
  Step();
  robot.KillPlanner();
  RunFor(9);
  EXPECT_EQ(feedback().status, Status::kProcessing) << feedback().message;
  robot.planner_up = true;
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
  ASSERT_FALSE(run().errors().empty());
  EXPECT_THAT(run().errors()[0].what, StartsWith("No response from planner"));
}

TEST_F(NavigateTo, NoticesAPlannerThatIsLostWithoutAWord) {
  robot.answers = false;
  Go();
  ASSERT_TRUE(RunToState("PLANNING"));
  robot.planner_up = false;
  RunFor(2.5);
  EXPECT_EQ(feedback().state, "PLANNING");
  RunFor(1);
  EXPECT_EQ(feedback().state, "INITIALIZING");
  EXPECT_EQ(run().errors()[0].what, "No response from planner");
}

TEST_F(NavigateTo, GivesUpWhenThePlannerStaysLost) {
  Go();
  ASSERT_TRUE(RunToState("PLANNING"));
  robot.KillPlanner();
  ExpectFailure(60, "Path planner server not available: no planner of robot_0, waited for 20 s");
  EXPECT_GE(run().now(), std::chrono::seconds(20));
}

TEST_F(NavigateTo, WaitsForALostControllerAndGoesOn) {
  Go();
  ASSERT_TRUE(RunToState("EXECUTING"));
  RunFor(1);
  robot.KillController();
  RunFor(5);
  EXPECT_TRUE(robot.Rests());
  robot.controller_up = true;
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
}

TEST_F(NavigateTo, WaitsForAPlannerThatRejectsRequestsUntilItIsActive) {
  Go();
  ASSERT_TRUE(RunToState("PLANNING"));
  Step();
  robot.KillPlanner();
  RunFor(1);
  robot.planner_up = true;
  const auto plan = robot.plan;
  robot.plan = [](const auto&, const auto&) -> Result<navigation::Path> {
    return Error{kCodeStateInvalid, "it is not Active"};
  };
  RunFor(6);
  robot.plan = plan;
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
}

TEST_F(NavigateTo, PlansAgainWhenTheControllerDoesNotAnswer) {
  Go();
  ASSERT_TRUE(RunToState("EXECUTING"));
  RunFor(1);
  robot.FailDrive({kCodeNetError, "no reply within 3 s"});
  Step();
  EXPECT_EQ(run().errors()[0].what, "No response from controller: no reply within 3 s");
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
}

TEST_F(NavigateTo, StopsADriveWithoutOdometry) {
  Go();
  ASSERT_TRUE(RunToState("EXECUTING"));
  robot.drive_speed_m_s = 0.1;
  robot.odometry_up = false;
  RunFor(4);
  EXPECT_TRUE(robot.Rests());
  robot.odometry_up = true;
  robot.drive_speed_m_s = 1;
  EXPECT_TRUE(RunToItsEnd(30));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
}

TEST_F(NavigateTo, StandsBeforeItIsCancelledInEachState) {
  for (const char* state : {"INITIALIZING", "PLANNING", "EXECUTING"}) {
    robot.at = {};
    robot.planning_time = std::chrono::seconds(1);
    Go();
    ASSERT_TRUE(RunToState(state));
    if (std::string(state) == "EXECUTING") RunFor(2);
    ASSERT_TRUE(manager->Cancel("navigate_to", "the test"));
    bool moves = !robot.Rests();
    EachStep([&] { moves = run().running() && !robot.Rests(); });
    ASSERT_TRUE(RunToItsEnd(3)) << state;
    EXPECT_FALSE(moves) << state;
    EXPECT_TRUE(robot.Rests()) << state;
    EXPECT_EQ(feedback().status, Status::kCancelled) << state;
    EXPECT_EQ(feedback().message, "the test");
    EachStep([] {});
  }
}

TEST_F(NavigateTo, StandsInAPauseAndPlansAgainAfterIt) {
  for (const char* state : {"INITIALIZING", "PLANNING", "EXECUTING"}) {
    robot.at = {};
    Go();
    ASSERT_TRUE(RunToState(state));
    if (std::string(state) == "EXECUTING") RunFor(2);
    Pause();
    RunFor(300);
    EXPECT_TRUE(robot.Rests()) << state;
    const int plans = robot.plans;
    Resume();
    EXPECT_TRUE(RunToItsEnd(20)) << state;
    EXPECT_EQ(feedback().status, Status::kCompleted) << state << ": " << feedback().message;
    EXPECT_EQ(robot.plans, plans + 1) << state;
  }
}

TEST_F(NavigateTo, EndsAtOnceInAnEmergency) {
  Go();
  ASSERT_TRUE(RunToState("EXECUTING"));
  RunFor(2);
  manager->CancelAllNow("emergency stop");
  EXPECT_EQ(feedback().status, Status::kCancelled);
  ExpectRest();
}

TEST_F(NavigateTo, DoesNotMindAClockThatJumpsBack) {
  Go();
  ASSERT_TRUE(RunToState("EXECUTING"));
  now -= std::chrono::hours(1);
  EXPECT_TRUE(RunToItsEnd(20));
  EXPECT_EQ(feedback().status, Status::kCompleted) << feedback().message;
}

}  // namespace musher::navigate_to_test
