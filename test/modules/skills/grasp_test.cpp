// grasp and place: what they have beyond pick_up and put_down.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "musher/test/modules/skills/fake_robot.hpp"

namespace musher::skills::grasp_test {

using skill::Numbers;
using skill::Status;
using skill::Values;
using testing::Bench;
using ::testing::Contains;
using ::testing::HasSubstr;
using testing::Reply;

class Grasping : public ::testing::Test {
 protected:
  Grasping() { bench_.robot.seen = {{"box_red", "box", {{1, 0, 0}, 0}, ""}}; }
  SeenObject& Box() { return bench_.robot.Object("box_red"); }
  Values With(const Values& more, Values parameters) {
    for (const auto& named : more) parameters.Set(named.name, named.value);
    return parameters;
  }
  const skill::Feedback& Grasp(const Values& more = {}) {
    return bench_.Execute("grasp", With(more, {{"object_prim_path", "box_red"}}));
  }
  const skill::Feedback& Place(const Numbers& target, const Values& more = {}) {
    return bench_.Execute("place", With(more, {{"target_location", target}}));
  }
  void ExpectStand() { EXPECT_EQ(bench_.robot.command, navigation::Velocity{}); }
  double Driven() const { return std::hypot(bench_.robot.body.at.x_m, bench_.robot.body.at.y_m); }
  Bench bench_{"jetbot_0", "jetbot"};
};

TEST_F(Grasping, GraspsWhatIsNearEnoughWithoutADrive) {
  const skill::Feedback& end = Grasp();
  EXPECT_EQ(end.status, Status::kCompleted);
  EXPECT_EQ(end.message, "Object attached");
  EXPECT_EQ(end.details.Text("holds"), "box_red");
  EXPECT_EQ(bench_.robot.Held(), "box_red");
  EXPECT_EQ(Driven(), 0);
  EXPECT_THAT(bench_.messages, Contains("70 Attaching object"));
}

TEST_F(Grasping, ComesCloserWhenLittleIsMissing) {
  Box().pose.at = {-2, 0.9, 0};  // behind it
  EXPECT_EQ(Grasp({{"distance_threshold", 1.9}}).status, Status::kCompleted);
  EXPECT_THAT(bench_.messages, Contains("40 Approaching"));
  EXPECT_NEAR(navigation::Distance(Box().pose.at, bench_.robot.body.at), 1.9, 0.05);
  ExpectStand();
}

TEST_F(Grasping, DoesNotComeCloserWhenMuchIsMissing) {
  Box().pose.at = {3, 0, 0};
  EXPECT_EQ(Grasp().message, "Too far: 3.00m > 2.00m");
  EXPECT_EQ(Driven(), 0);
}

TEST_F(Grasping, DrivesNoFartherThanItMay) {
  Box().pose.at = {2, 0, 0};
  bench_.robot.reach_m = 0.5;  // less than its threshold says
  EXPECT_EQ(Grasp({{"approach", 0.4}}).message,
            "Too far: the hand does not reach it; it has come as close as it may");
  EXPECT_NEAR(Driven(), 0.4, 0.06);
  ExpectStand();
}

TEST_F(Grasping, ComesNoCloserWithoutAScanAndStopsForAnObstacle) {
  Box().pose.at = {2.3, 0, 0};
  bench_.robot.has_scan = false;
  EXPECT_EQ(Grasp().message, "Too far: 2.30m > 2.00m; stopped: no scan to approach by");
  bench_.robot.has_scan = true;
  bench_.robot.scan = {{0.5, 0.05, 0}};
  EXPECT_THAT(Grasp().message, HasSubstr("m > 2.00m; an obstacle is in the way"));
  EXPECT_LT(Driven(), 0.3);
  ExpectStand();
}

// The object itself, and what is behind the robot, are no obstacles.
TEST_F(Grasping, DrivesTowardsAnObjectThatItsScanSees) {
  Box().pose.at = {0.6, 0, 0};
  bench_.robot.scan = {{0.5, 0, 0}, {-0.25, 0, 0}};
  EXPECT_EQ(Grasp({{"distance_threshold", 0.4}}).status, Status::kCompleted);
}

TEST_F(Grasping, FollowsAnObjectThatMovesOff) {
  bench_.Start("grasp", {{"object_prim_path", "box_red"}});
  while (bench_.feedback().message != "Attaching object") bench_.Step();
  Box().pose.at = {2.2, 0, 0};
  EXPECT_EQ(bench_.RunOut().status, Status::kCompleted);
  EXPECT_EQ(bench_.run().retries(), 1);
  EXPECT_THAT(bench_.messages, Contains("40 Approaching"));
}

TEST_F(Grasping, RetriesAnObjectThatSlips) {
  bench_.robot.slips = true;
  bench_.Start("grasp", {{"object_prim_path", "box_red"}});
  bench_.StepFor(1.8);
  bench_.robot.slips = false;
  EXPECT_EQ(bench_.RunOut().status, Status::kCompleted);
  EXPECT_EQ(bench_.run().retries(), 1);
  EXPECT_THAT(bench_.run().errors()[0].what, HasSubstr("box_red is not in the hand"));
  EXPECT_EQ(bench_.robot.Held(), "box_red");
}

TEST_F(Grasping, GivesUpOnAnObjectThatSlipsAlways) {
  bench_.robot.slips = true;
  EXPECT_EQ(Grasp().message, "gives up after 3 retries: box_red is not in the hand");
  EXPECT_EQ(bench_.Execute("put_down").message, "Joint path not found: jetbot_0 holds nothing");
}

TEST_F(Grasping, RetriesLostReplies) {
  bench_.robot.hand_replies = [](const HandRequest&) { return Reply::kAbandoned; };
  EXPECT_EQ(Grasp().message,
            "gives up after 3 retries: The hand has not replied: the work was abandoned");
}

TEST_F(Grasping, AHandThatStopsReplyingWhileItDrivesStopsItAtItsLimit) {
  Box().pose.at = {2.4, 0, 0};
  bench_.Start("grasp", {{"object_prim_path", "box_red"}});
  bench_.StepFor(1);
  ASSERT_EQ(bench_.feedback().message, "Approaching");
  bench_.robot.hand_replies = [](const HandRequest&) { return Reply::kNever; };
  EXPECT_EQ(bench_.RunOut().status, Status::kFailed);
  EXPECT_LT(Driven(), 0.56);
  ExpectStand();
}

TEST_F(Grasping, ACancellationWhileItDrivesStopsIt) {
  Box().pose.at = {2.4, 0, 0};
  bench_.Start("grasp", {{"object_prim_path", "box_red"}});
  bench_.StepFor(1);
  ASSERT_NE(bench_.robot.command, navigation::Velocity{});
  ASSERT_TRUE(bench_.manager().Cancel("grasp", "").ok());
  EXPECT_EQ(bench_.RunOut().status, Status::kCancelled);
  ExpectStand();
}

TEST_F(Grasping, ACancellationWhileTheHandTakesItSaysWhatItHolds) {
  bench_.Start("grasp", {{"object_prim_path", "box_red"}});
  while (bench_.feedback().message != "Attaching object" ||
         bench_.robot.hand_requests.back().action != HandAction::kAttach) {
    bench_.Step();
  }
  ASSERT_TRUE(bench_.manager().Cancel("grasp", "").ok());
  EXPECT_EQ(bench_.RunOut().status, Status::kCancelled);
  EXPECT_EQ(bench_.feedback().details.Text("holds"), "box_red");
  EXPECT_EQ(bench_.Execute("put_down").message, "Object put down");
}

TEST_F(Grasping, APauseStopsItAndItGoesOn) {
  Box().pose.at = {2.4, 0, 0};
  bench_.Start("grasp", {{"object_prim_path", "box_red"}});
  bench_.StepFor(1);
  bench_.manager().Pause();
  ExpectStand();
  EXPECT_EQ(bench_.RunOut().status, Status::kCompleted);
}

// An emergency stop gives the skill no time to end in an orderly way.
TEST_F(Grasping, ACancellationAtOnceStopsTheDrive) {
  Box().pose.at = {2.4, 0, 0};
  bench_.Start("grasp", {{"object_prim_path", "box_red"}});
  bench_.StepFor(1);
  ASSERT_NE(bench_.robot.command, navigation::Velocity{});
  ASSERT_TRUE(bench_.manager().CancelNow("grasp", "emergency stop").ok());
  ExpectStand();
  Box().held_by = "jetbot_0";
  bench_.Start("place", {{"target_location", Numbers{0, 2.4, 0}}});
  bench_.StepFor(1);
  ASSERT_NE(bench_.robot.command, navigation::Velocity{});
  ASSERT_TRUE(bench_.manager().CancelNow("place", "emergency stop").ok());
  ExpectStand();
}

TEST_F(Grasping, APauseStopsThePlacingRobotAndItGoesOn) {
  Grasp();
  bench_.Start("place", {{"target_location", Numbers{0, 2.3, 0}}});
  bench_.StepFor(1);
  ASSERT_NE(bench_.robot.command, navigation::Velocity{});
  bench_.manager().Pause();
  ExpectStand();
  EXPECT_EQ(bench_.RunOut().status, Status::kCompleted);
}

TEST_F(Grasping, PlacesWhatItHolds) {
  Grasp();
  const skill::Feedback& end = Place({1.5, 0.5, 0.7});
  EXPECT_EQ(end.status, Status::kCompleted);
  EXPECT_EQ(end.message, "Object placed");
  EXPECT_EQ(Box().pose.at, (navigation::Point{1.5, 0.5, 0.7}));
  EXPECT_EQ(bench_.robot.Held(), "");
  EXPECT_THAT(bench_.messages, Contains("70 Placing object"));
}

TEST_F(Grasping, PlaceComesCloserWhenLittleIsMissing) {
  Grasp();
  EXPECT_EQ(Place({0, 2.3, 0}).status, Status::kCompleted);
  EXPECT_NEAR(bench_.robot.body.at.y_m, 0.3, 0.06);
  ExpectStand();
}

TEST_F(Grasping, PlaceFailsWhenMuchIsMissing) {
  Grasp();
  EXPECT_EQ(Place({0, 5, 0}).message, "Too far: 5.00m > 2.00m");
  EXPECT_EQ(bench_.robot.Held(), "box_red");
}

TEST_F(Grasping, PlaceComesCloserForAHandThatReachesLess) {
  Grasp();
  bench_.robot.reach_m = 1.2;
  EXPECT_EQ(Place({1.5, 0, 0}).status, Status::kCompleted);
  EXPECT_NEAR(bench_.robot.body.at.x_m, 0.35, 0.15);
  EXPECT_GT(bench_.run().replans(), 0);
  Box().held_by = "jetbot_0";
  bench_.StepFor(2);
  EXPECT_EQ(Place({0.4, 4, 0}, {{"distance_threshold", 5.0}}).message,
            "Too far: the hand does not reach the target; it has come as close as it may");
}

TEST_F(Grasping, PlaceFailsWhenTheObjectDoesNotStandAtTheTarget) {
  Grasp();
  bench_.robot.slips = true;
  EXPECT_EQ(Place({1, 0, 0}).message, "box_red does not stand at the target");
  EXPECT_NEAR(bench_.feedback().details.Number("off_target_m"), 0.5, 1e-9);
}

TEST_F(Grasping, PlaceRefusesInvalidParameters) {
  EXPECT_EQ(Place({1, 0, 0}).message, "Joint path not found: jetbot_0 holds nothing");
  Grasp();
  EXPECT_EQ(Place({1, 0}).message, "Invalid target_location: expected three numbers");
  EXPECT_EQ(Place({1, 0, 0}, {{"approach", -1.0}}).message, "Invalid approach: it is negative");
  EXPECT_FALSE(bench_.manager().Start("place", {}).ok());
  EXPECT_EQ(Place({1, 0, 0}, {{"object_prim_path", "cup"}}).message,
            "Joint path not found: jetbot_0 holds box_red, not cup");
}

TEST_F(Grasping, APlaceWhoseReplyIsLostIsDone) {
  Grasp();
  bench_.StepFor(2);
  bench_.robot.hand_replies = [](const HandRequest&) { return Reply::kFails; };
  bench_.Start("place", {{"target_location", Numbers{1.2, 0, 0}}});
  bench_.StepFor(0.3);
  Box() = {"box_red", "box", {{1.2, 0, 0}, 0}, ""};
  EXPECT_EQ(bench_.RunOut().message, "Object placed");
}

TEST_F(Grasping, PlaceWaitsForTheHandAtACancellation) {
  Grasp();
  bench_.Start("place", {{"target_location", Numbers{1.2, 0, 0}}});
  while (bench_.robot.hand_requests.back().action != HandAction::kPlace) bench_.Step();
  ASSERT_TRUE(bench_.manager().Cancel("place", "").ok());
  EXPECT_EQ(bench_.RunOut().status, Status::kCancelled);
  EXPECT_EQ(bench_.Execute("put_down").message, "Joint path not found: jetbot_0 holds nothing");
}

}  // namespace musher::skills::grasp_test
