// pick_up and put_down.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/test/modules/skills/fake_robot.hpp"

namespace musher::skills::pick_up_test {

using skill::Numbers;
using skill::Status;
using skill::Values;
using testing::Bench;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Reply;

class Hand : public ::testing::Test {
 protected:
  Hand() {
    bench_.robot.seen = {{"box_red", "box", {{1, 0, 0}, 0}, ""}, {"cup", "", {{0, 1, 0}, 0}, ""}};
  }
  const skill::Feedback& PickUp(const Values& more = {}) {
    Values parameters{{"object_prim_path", "box_red"}};
    for (const auto& named : more) parameters.Set(named.name, named.value);
    return bench_.Execute("pick_up", parameters);
  }
  // The replies to one action; the others are given.
  void Replies(HandAction action, Reply reply) {
    bench_.robot.hand_replies = [action, reply](const HandRequest& request) {
      return request.action == action ? reply : Reply::kGiven;
    };
  }
  Bench bench_{"jetbot_0", "jetbot"};
};

TEST_F(Hand, PicksUpAnObjectInTwoSteps) {
  const skill::Feedback& end = PickUp();
  EXPECT_EQ(end.status, Status::kCompleted);
  EXPECT_EQ(bench_.robot.Held(), "box_red");
  EXPECT_THAT(bench_.messages,
              ElementsAre("20 Checking distance", "30 Checking distance", "60 Attaching object",
                          "70 Attaching object", "100 Object picked up"));
  ASSERT_EQ(bench_.robot.hand_requests.size(), 2U);
  EXPECT_EQ(bench_.robot.hand_requests[0].action, HandAction::kCheckDistance);
  EXPECT_EQ(bench_.robot.hand_requests[1].action, HandAction::kAttach);
  EXPECT_EQ(bench_.robot.hand_requests[1].distance_threshold_m, 2);
}

TEST_F(Hand, TakesAPathOfASceneAsWell) {
  EXPECT_EQ(PickUp({{"object_prim_path", "/World/box_red"}}).status, Status::kCompleted);
  EXPECT_EQ(bench_.robot.hand_requests[0].object, "box_red");
}

TEST_F(Hand, ReportsHowFarTheObjectIs) {
  bench_.robot.Object("box_red").pose.at = {3, 0, 0};
  const skill::Feedback& end = PickUp();
  EXPECT_EQ(end.status, Status::kFailed);
  EXPECT_EQ(end.message, "Too far: 3.00m > 2.00m");
  EXPECT_NEAR(end.details.Number("distance_m"), 3, 1e-9);
  EXPECT_EQ(PickUp({{"distance_threshold", 3.5}}).status, Status::kCompleted);
}

TEST_F(Hand, TakesTheTextOfAHandThatReachesLess) {
  bench_.robot.reach_m = 0.5;
  EXPECT_EQ(PickUp().message, "Too far: the hand does not reach it");
}

TEST_F(Hand, RefusesInvalidParameters) {
  EXPECT_FALSE(bench_.manager().Start("pick_up", {}).ok());
  EXPECT_EQ(PickUp({{"robot_hand_prim_path", ""}}).message, "Hand path required");
  EXPECT_EQ(PickUp({{"object_prim_path", ""}}).message, "Object path required");
  EXPECT_EQ(PickUp({{"distance_threshold", 0.0}}).message,
            "Invalid distance_threshold: it is not above 0 m");
  EXPECT_EQ(PickUp({{"axis", Numbers{0, 1}}}).message, "Invalid axis: expected three numbers");
  EXPECT_THAT(bench_.robot.hand_requests, IsEmpty());
}

TEST_F(Hand, ARobotWithoutAHandRefuses) {
  bench_.robot.has_hand = false;
  EXPECT_EQ(PickUp().message, "jetbot_0 has no hand");
  EXPECT_EQ(bench_.Execute("put_down").message, "jetbot_0 has no hand");
  EXPECT_EQ(bench_.Execute("grasp", {{"object_prim_path", "box_red"}}).message,
            "jetbot_0 has no hand");
  EXPECT_EQ(bench_.Execute("place", {{"target_location", Numbers{0, 0, 0}}}).message,
            "jetbot_0 has no hand");
}

TEST_F(Hand, PassesOnWhyTheHandRefuses) {
  EXPECT_EQ(PickUp({{"object_prim_path", "bix"}}).message, "there is no object 'bix'");
  bench_.robot.Object("box_red").held_by = "jetbot_1";
  EXPECT_EQ(PickUp().message, "held by jetbot_1");
}

TEST_F(Hand, HoldsOneObjectAtOnce) {
  PickUp();
  EXPECT_EQ(PickUp({{"object_prim_path", "cup"}}).message,
            "jetbot_0 holds box_red already; put it down first");
  bench_.robot.hand_requests.clear();
  EXPECT_EQ(PickUp().message, "Object picked up");  // nothing to do
  EXPECT_THAT(bench_.robot.hand_requests, IsEmpty());
}

TEST_F(Hand, AnObjectThatMovesOffIsCheckedAgain) {
  bench_.Start("pick_up", {{"object_prim_path", "box_red"}});
  bench_.StepFor(0.3);
  ASSERT_EQ(bench_.run().Path(), "ATTACHING");
  bench_.robot.Object("box_red").pose.at.x_m = 5;
  bench_.StepFor(0.3);
  EXPECT_EQ(bench_.run().Path(), "INITIALIZING");
  bench_.robot.Object("box_red").pose.at.x_m = 1;
  EXPECT_EQ(bench_.RunOut().status, Status::kCompleted);
  EXPECT_EQ(bench_.run().retries(), 1);
}

TEST_F(Hand, RetriesLostRepliesThreeTimes) {
  for (const Reply reply : {Reply::kFails, Reply::kAbandoned}) {
    for (const HandAction action : {HandAction::kCheckDistance, HandAction::kAttach}) {
      Replies(action, reply);
      EXPECT_THAT(PickUp().message,
                  HasSubstr("gives up after 3 retries: The hand has not replied: the "));
      EXPECT_EQ(bench_.run().retries(), 3);
    }
  }
}

// The hand took the object, and only the reply was lost.
TEST_F(Hand, ARetryFindsTheObjectInTheHand) {
  Replies(HandAction::kAttach, Reply::kFails);
  bench_.Start("pick_up", {{"object_prim_path", "box_red"}});
  bench_.StepFor(0.5);
  bench_.robot.Object("box_red").held_by = "jetbot_0";
  EXPECT_EQ(bench_.RunOut().message, "Object picked up");
}

TEST_F(Hand, AHandThatNeverRepliesFailsAfterThreeSeconds) {
  for (const HandAction action : {HandAction::kCheckDistance, HandAction::kAttach}) {
    Replies(action, Reply::kNever);
    EXPECT_EQ(PickUp().message, "Timeout: the hand has not replied after 3 s");
  }
  Replies(HandAction::kAttach, Reply::kGiven);
  PickUp();
  Replies(HandAction::kRelease, Reply::kNever);
  EXPECT_EQ(bench_.Execute("put_down").message, "Timeout: the hand has not replied after 3 s");
}

TEST_F(Hand, PutsDownWhatItHolds) {
  PickUp();
  const skill::Feedback& end = bench_.Execute("put_down");
  EXPECT_EQ(end.status, Status::kCompleted);
  EXPECT_EQ(bench_.robot.Held(), "");
  EXPECT_THAT(bench_.messages,
              ElementsAre("50 Releasing object", "70 Releasing object", "100 Object put down"));
  EXPECT_EQ(bench_.Execute("put_down").message, "Joint path not found: jetbot_0 holds nothing");
}

TEST_F(Hand, PutsDownTheNamedObjectAndTheOneOfAJoint) {
  PickUp();
  EXPECT_EQ(bench_.Execute("put_down", {{"object_prim_path", "cup"}}).message,
            "Joint path not found: jetbot_0 holds box_red, not cup");
  EXPECT_EQ(bench_.Execute("put_down", {{"joint_path", "/World/grasp_joint_cup"}}).message,
            "Joint path not found: jetbot_0 holds box_red, not cup");
  EXPECT_EQ(bench_.Execute("put_down", {{"joint_path", "/World/grasp_joint_box_red"}}).message,
            "Object put down");
  PickUp();
  EXPECT_EQ(bench_.Execute("put_down", {{"object_prim_path", "/World/box_red"}}).message,
            "Object put down");
}

// Without objects, and right after the hand has taken it, the skills remember it themselves.
TEST_F(Hand, RemembersWhatItHoldsWithoutObjects) {
  bench_.robot.has_objects = false;
  EXPECT_EQ(PickUp().status, Status::kCompleted);
  bench_.StepFor(100);
  EXPECT_EQ(bench_.Execute("put_down").message, "Object put down");
  EXPECT_EQ(bench_.Execute("put_down").message, "Joint path not found: jetbot_0 holds nothing");
}

TEST_F(Hand, KnowsWhatItHoldsAfterARestart) {
  bench_.robot.Object("cup").held_by = "jetbot_0";
  EXPECT_EQ(bench_.Execute("put_down").message, "Object put down");
  EXPECT_EQ(bench_.robot.hand_requests.back().object, "cup");
}

TEST_F(Hand, BelievesObjectsThatLagForASecondOnly) {
  PickUp();
  bench_.robot.Object("box_red").held_by = "";  // as shown a moment ago, or fallen
  bench_.Start("put_down");
  bench_.Step();
  EXPECT_EQ(bench_.run().Path(), "RELEASING");
  bench_.RunOut();
  bench_.StepFor(1.5);
  EXPECT_EQ(bench_.Execute("put_down").message, "Joint path not found: jetbot_0 holds nothing");
}

TEST_F(Hand, AReleaseWhoseReplyIsLostIsDone) {
  PickUp();
  Replies(HandAction::kRelease, Reply::kFails);
  bench_.StepFor(2);
  bench_.Start("put_down");
  bench_.StepFor(0.2);
  bench_.robot.Object("box_red").held_by = "";
  EXPECT_EQ(bench_.RunOut().message, "Object put down");
}

TEST_F(Hand, ACancellationBeforeTheHandTakesItEndsAtOnce) {
  for (const double after_s : {0.0, 0.1, 0.3}) {
    bench_.Start("pick_up", {{"object_prim_path", "box_red"}});
    bench_.StepFor(after_s);
    ASSERT_TRUE(bench_.manager().Cancel("pick_up", "").ok());
    bench_.Step();
    EXPECT_EQ(bench_.feedback().status, Status::kCancelled) << after_s;
    bench_.StepFor(1);
    EXPECT_EQ(bench_.robot.Held(), "") << after_s;
  }
}

TEST_F(Hand, ACancellationWhileTheHandTakesItReportsTheHeldObject) {
  bench_.Start("pick_up", {{"object_prim_path", "box_red"}});
  bench_.StepFor(0.4);
  ASSERT_EQ(bench_.feedback().message, "Attaching object");
  ASSERT_TRUE(bench_.manager().Cancel("pick_up", "").ok());
  EXPECT_EQ(bench_.RunOut().message, "jetbot_0 holds box_red");
  EXPECT_EQ(bench_.feedback().status, Status::kCancelled);
  EXPECT_EQ(bench_.Execute("put_down").message, "Object put down");
}

TEST_F(Hand, ACancellationWaitsForTheHandNoLongerThanItsLimit) {
  for (const Reply reply : {Reply::kNever, Reply::kFails}) {
    Replies(HandAction::kAttach, reply);
    bench_.Start("pick_up", {{"object_prim_path", "box_red"}});
    bench_.StepFor(0.4);
    ASSERT_TRUE(bench_.manager().Cancel("pick_up", "").ok());
    EXPECT_EQ(bench_.RunOut().status, Status::kCancelled);
  }
  EXPECT_LT(bench_.seconds(), 5);
}

TEST_F(Hand, ACancelledReleaseWaitsForTheHand) {
  PickUp();
  bench_.Start("put_down");
  bench_.StepFor(0.2);
  ASSERT_TRUE(bench_.manager().Cancel("put_down", "").ok());
  EXPECT_EQ(bench_.RunOut().message, "the object is put down");
  PickUp();
  bench_.Start("put_down");
  ASSERT_TRUE(bench_.manager().Cancel("put_down", "").ok());
  EXPECT_EQ(bench_.RunOut().message, "no reason was given");
  EXPECT_EQ(bench_.robot.Held(), "box_red");
}

TEST_F(Hand, GoesOnAfterAPauseInEachState) {
  for (int steps = 0; steps < 6; ++steps) {
    bench_.Start("pick_up", {{"object_prim_path", "box_red"}});
    for (int i = 0; i < steps && bench_.run().running(); ++i) bench_.Step();
    bench_.manager().Pause();
    for (int i = 0; i < 100; ++i) bench_.robot.Advance(Milliseconds(100));
    EXPECT_EQ(bench_.RunOut().status, Status::kCompleted) << steps;
    bench_.Execute("put_down");
    bench_.robot.Object("box_red").pose.at = {1, 0, 0};
  }
}

}  // namespace musher::skills::pick_up_test
