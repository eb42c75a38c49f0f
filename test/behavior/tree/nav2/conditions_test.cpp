// The conditions of nav2, in virtual time.

#include "musher/test/behavior/tree/nav2/fake_robot.hpp"

namespace musher::tree::nav2::conditions_test {

using AGoalUpdated = Nav2Tree;
// Each tick of a reactive control resets the condition; it compares with the tick before all the
// same, so that a new goal ends a recovery.
TEST_F(AGoalUpdated, EndsWhatRunsBehindItInAReactiveFallback) {
  Make("<ReactiveFallback><GoalUpdated/>" + SayXml("a", "R") + "</ReactiveFallback>");
  Put("goal", Pose{.x_m = 1});
  EXPECT_EQ(NextTicks(2), "R a^ \nR a \n");
  Put("goal", Pose{.x_m = 2});
  EXPECT_EQ(Next(), "S a! ");
}
TEST_F(AGoalUpdated, DoesNotCountAChangeBeforeItBegins) {
  Make("<Sequence>" + SayXml("a", "SRS") + "<Fallback><GoalUpdated/>" + SayXml("b", "S") +
       "</Fallback></Sequence>");
  Put("goal", Pose{.x_m = 1});
  EXPECT_EQ(Next(), "S a^ b^ ");
  Put("goal", Pose{.x_m = 2});
  EXPECT_EQ(NextTicks(2), "R a^ \nS a b^ \n");
}
TEST_F(AGoalUpdated, BeginsAgainAfterTheEndOfTheTreeAndAfterAHalt) {
  Make("<GoalUpdated/>");
  Put("goal", Pose{.x_m = 1});
  EXPECT_EQ(Next(), "F ");
  Put("goal", Pose{.x_m = 2});
  EXPECT_EQ(Next(), "F ");
  Make("<ReactiveFallback><GoalUpdated/>" + SayXml("a", "R") + "</ReactiveFallback>");
  EXPECT_EQ(Next(), "R a^ ");
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  Take();
  Put("goals", Goals{{Pose{}}});
  EXPECT_EQ(Next(), "R a^ ");
}

TEST_F(AGoalUpdated, DiffersFromGlobalUpdatedGoalWhichKnowsTheGoalForEver) {
  Make("<GlobalUpdatedGoal/>");
  EXPECT_EQ(Next(), "S ") << "the first time";
  EXPECT_EQ(Next(), "F ");
  Put("goal", Pose{.x_m = 2});
  ASSERT_TRUE(tree->Halt(At(now_ms)));
  EXPECT_EQ(NextTicks(2), "S \nF \n");
}

using Conditions = Nav2Tree;
TEST_F(Conditions, GoalReachedIsWithinItsTolerance) {
  Make("<GoalReached goal=\"1;0;0\"/>");
  EXPECT_EQ(Next(), "F ");
  robot.at = Pose{.x_m = 0.76, .yaw_rad = 2};
  EXPECT_EQ(Next(), "S ");
  robot.at.reset();
  EXPECT_EQ(Next(), "F ");
}
TEST_F(Conditions, CountTheHeightOnlyOfARobotThatFlies) {
  robot.at->z_m = 0.7;
  Make("<GoalReached goal=\"0;0;0\"/>");
  EXPECT_EQ(Next(), "S ");
  robot.has_wings = true;
  EXPECT_EQ(Next(), "F ");
  Make("<ArePosesNear ref_pose=\"0;0;0\" target_pose=\"{other}\" tolerance=\"0.5\"/>");
  Put("other", Pose{.z_m = 0.7});
  EXPECT_EQ(Next(), "F ");
  robot.has_wings = false;
  EXPECT_EQ(Next(), "S ");
  Make("<ReactiveFallback><DistanceTraveled distance=\"1\"/>" + SayXml("a", "R") +
       "</ReactiveFallback>");
  EXPECT_EQ(Next(), "R a^ ");
  robot.at->z_m = 2;
  EXPECT_EQ(Next(), "R a ");
  robot.has_wings = true;
  EXPECT_EQ(Next(), "S a! ");
}
TEST_F(Conditions, DistanceTraveledSucceedsEachTimeTheRobotHasTravelledSoFar) {
  Make("<ReactiveFallback><DistanceTraveled distance=\"1\"/>" + SayXml("a", "R") +
       "</ReactiveFallback>");
  EXPECT_EQ(Next(), "R a^ ");
  robot.at->x_m = 0.9;
  EXPECT_EQ(Next(), "R a ");
  robot.at->x_m = 1;
  EXPECT_EQ(Next(), "S a! ");
  robot.at->x_m = 2.5;
  EXPECT_EQ(Next(), "R a^ ") << "it begins where it is";
}
TEST_F(Conditions, TimeExpiredSucceedsEachTimeSoManySecondsHavePassed) {
  Make("<ReactiveFallback><TimeExpired seconds=\"0.5\"/>" + SayXml("a", "R") +
       "</ReactiveFallback>");
  EXPECT_EQ(TickAt(1000), "R a^ ");
  EXPECT_EQ(TickAt(1499), "R a ");
  EXPECT_EQ(TickAt(1500), "S a! ");
}
TEST_F(Conditions, RefuseADistanceAndATimeThatAreNoNumber) {
  for (const std::string node :
       {"DistanceTraveled distance", "TimeExpired seconds", "PathExpiringTimer seconds",
        "ArePosesNear ref_pose=\"0;0;0\" target_pose=\"0;0;0\" tolerance"}) {
    for (const std::string number : {"nan", "-1"}) {
      Make("<" + node + "=\"" + number + "\"/>");
      EXPECT_EQ(Next(), "! ") << node << " " << number;
      EXPECT_THAT(fault, testing::HasSubstr("has to be a number from 0"));
    }
  }
}
// Its parent starts it again in the tick after its end: it still knows the goal of that tick.
TEST_F(AGoalUpdated, ComparesWithTheTickBeforeWhereItsParentBeginsAgainAtOnce) {
  Make("<KeepRunningUntilFailure><Inverter><GoalUpdated/></Inverter></KeepRunningUntilFailure>");
  Put("goal", Pose{.x_m = 1});
  EXPECT_EQ(Next(), "R ");
  Put("goal", Pose{.x_m = 2});
  EXPECT_EQ(Next(), "F ");
}
TEST_F(Conditions, PathExpiringTimerBeginsAgainWithANewPath) {
  Make(
      "<KeepRunningUntilFailure><Inverter><PathExpiringTimer seconds=\"1\" path=\"{path}\"/>"
      "</Inverter></KeepRunningUntilFailure>");
  Put("path", Straight(1));
  EXPECT_EQ(TickAt(0), "R ");
  EXPECT_EQ(TickAt(900), "R ");
  Put("path", Straight(2));
  EXPECT_EQ(TickAt(1000), "R ");
  EXPECT_EQ(TickAt(1999), "R ");
  EXPECT_EQ(TickAt(2000), "F ");
  EXPECT_EQ(TickAt(2001), "R ") << "it begins again";
}
TEST_F(Conditions, PathExpiringTimerBeginsAgainWithARunOfTheTree) {
  Make("<ReactiveFallback><PathExpiringTimer seconds=\"1\"/>" + SayXml("a", "R") +
       "</ReactiveFallback>");
  EXPECT_EQ(TickAt(5000), "R a^ ");
  ASSERT_TRUE(tree->Halt(At(5500)));
  Take();
  EXPECT_EQ(TickAt(6500), "R a^ ");
  ASSERT_TRUE(tree->Halt(At(6500)));
  Take();
  tree->SetTime(At(0));
  EXPECT_EQ(TickAt(100), "R a^ ");
  EXPECT_EQ(TickAt(1100), "S a! ") << "the clock has jumped back";
}
TEST_F(Conditions, InitialPoseReceivedReadsItsEntry) {
  Make("<InitialPoseReceived/>");
  EXPECT_EQ(Next(), "F ");
  Put("initial_pose_received", true);
  EXPECT_EQ(Next(), "S ");
}
TEST_F(Conditions, ArePosesNearComparesPlaces) {
  Make("<ArePosesNear ref_pose=\"0;0;3\" target_pose=\"{other}\" tolerance=\"0.3\"/>");
  Put("other", Pose{.x_m = 0.3});
  EXPECT_EQ(Next(), "S ");
  Put("other", Pose{.x_m = 0.31});
  EXPECT_EQ(Next(), "F ");
}
TEST_F(Conditions, ErrorCodesSayWhetherARecoveryMayHelp) {
  const auto letters = [this](const std::string& node, const std::vector<std::uint16_t>& codes) {
    Make("<" + node + " error_code=\"{code}\"/>");
    std::string text = Next().substr(0, 1);
    for (const std::uint16_t code : codes) {
      EXPECT_TRUE(tree->board().Set("code", code));
      text += Next()[0];
    }
    return text;
  };
  EXPECT_EQ(letters("WouldAPlannerRecoveryHelp", {0, 200, 201, 204, 206, 207, 208}), "FFSFFFSS");
  EXPECT_EQ(letters("WouldAControllerRecoveryHelp", {0, 100, 101, 103, 104, 105, 106, 107}),
            "FFSFFSSSF");
  EXPECT_EQ(letters("WouldAPlannerRecoveryHelp error_codes_to_check=\"206\"", {206, 208}), "FSF");
  EXPECT_EQ(letters("AreErrorCodesPresent error_codes_to_check=\"7;9\"", {7, 8, 9}), "FSFS");
}

}  // namespace musher::tree::nav2::conditions_test
