// The acceptance criteria of the wedding robot, in their original order.

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "musher/behavior/fsm/graph.hpp"
#include "musher/modules/wedding/show_states.hpp"
#include "musher/test/modules/wedding/show_rig.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::wedding::acceptance_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class WeddingShow : public ShowRig {};

// --- start ---

TEST_F(WeddingShow, RunsInIdleInModeNormalOnceItIsStarted) {
  EXPECT_TRUE(machine_->running());
  EXPECT_EQ(state(), "IDLE");
  EXPECT_EQ(fsm::Name(mode()), "NORMAL");
}

TEST_F(WeddingShow, DoesNotStartInInvalidNorWithoutAnyState) {
  fsm::Machine machine;
  ShowData data;
  AddStates(machine, data, {});
  EXPECT_THAT(machine.Build("INVALID").error().message, HasSubstr("there is no state INVALID"));
  EXPECT_FALSE(machine.Start({}));
  fsm::Machine empty;
  EXPECT_THAT(empty.Build("IDLE").error().message, HasSubstr("no states are registered"));
}

TEST_F(WeddingShow, MatchesTheGraphInItsManual) {
  std::ifstream file(SourceDir() + "/modules/wedding/README.md");
  const std::string manual((std::istreambuf_iterator<char>(file)), {});
  EXPECT_THAT(manual, HasSubstr("```mermaid\n" + fsm::ToMermaid(machine_->chart()) + "```\n"));
}

TEST_F(WeddingShow, CountsOneTickAndIsStillInIdle) {
  Tick();
  EXPECT_EQ(machine_->ticks(), 1);
  EXPECT_EQ(state(), "IDLE");
}

// --- changes of state ---

TEST_F(WeddingShow, TracksAFaceWithinTwentyTicks) {
  EXPECT_EQ(TicksToWithFace("TRACKING", 20), 1) << "decided and done in one tick";
}

TEST_F(WeddingShow, IsForcedToAState) {
  Force("PHOTO_POSING");
  EXPECT_EQ(state(), "PHOTO_POSING");
}

TEST_F(WeddingShow, IsNotForcedToInvalid) {
  EXPECT_FALSE(show_->Force("INVALID", now_));
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(WeddingShow, IsInModeTransitioningOrNormalATickAfterAPhotoWasCommandedInTracking) {
  Track();
  Command("photo");
  Tick();
  EXPECT_TRUE(mode() == fsm::Mode::kTransitioning || mode() == fsm::Mode::kNormal);
  EXPECT_EQ(state(), "PHOTO_POSING");
}

TEST_F(WeddingShow, PosesForAPhotoWithinTwoTicksOfTheCommandInIdle) {
  Command("photo");
  Tick(2);
  EXPECT_EQ(state(), "PHOTO_POSING");
}

TEST_F(WeddingShow, IsInIdleWithinTwoTicksOfStop) {
  for (const char* from : {"TRACKING", "PHOTO_POSING", "FAREWELL"}) {
    Force(from);
    Command("stop");
    Tick(2);
    EXPECT_EQ(state(), "IDLE") << from;
  }
}

TEST_F(WeddingShow, IsInIdleWithoutTheSafetyFlagAfterAReset) {
  TooClose(true);
  Tick();
  ASSERT_TRUE(data().safety_triggered);
  TooClose(false);
  ASSERT_TRUE(show_->Reset(now_));
  EXPECT_EQ(state(), "IDLE");
  EXPECT_FALSE(data().safety_triggered);
}

// --- safety ---

TEST_F(WeddingShow, IsInSafeStopOneTickAfterAGuestIsTooClose) {
  for (const char* from : {"IDLE", "TRACKING", "PHOTO_POSING", "FAREWELL"}) {
    Force(from);
    TooClose(true);
    Tick();
    EXPECT_TRUE(data().safety_triggered) << from;
    EXPECT_EQ(fsm::Name(mode()), "SAFE_STOP") << from;
    EXPECT_EQ(state(), "SAFE_STOP") << from;
    TooClose(false);
  }
}

TEST_F(WeddingShow, IsBackInIdleWithinThreeSecondsOfNoGuestBeingTooClose) {
  TooClose(true);
  Tick();
  TooClose(false);
  EXPECT_EQ(TicksTo("IDLE", 150), 100) << "2.0 s";
  EXPECT_FALSE(data().safety_triggered);
}

// --- monitoring ---

TEST_F(WeddingShow, PublishesEachChangeOfStateForcedOnesToo) {
  class Watch : public fsm::Listener {
   public:
    void OnChange(const fsm::Machine& machine, const fsm::Change& change) override {
      seen.push_back(std::string(machine.Name(change.from)) + ">" +
                     std::string(machine.Name(change.to)));
    }
    std::vector<std::string> seen;
  } watch;
  machine_->Listen(&watch);
  Force("PHOTO_POSING");
  Command("stop");
  Tick();
  machine_->Forget(&watch);
  EXPECT_THAT(watch.seen, ElementsAre("IDLE>PHOTO_POSING", "PHOTO_POSING>IDLE"));
  EXPECT_THAT(script_.states, ElementsAre("IDLE", "PHOTO_POSING", "IDLE"));
}

TEST_F(WeddingShow, CanBeQueriedForItsState) {
  Tick(3);
  EXPECT_TRUE(machine_->running());
  EXPECT_EQ(state(), "IDLE");
  EXPECT_THAT(std::string(fsm::Name(mode())), HasSubstr("NORMAL"));
  EXPECT_EQ(machine_->ticks(), 3);
  EXPECT_FALSE(data().safety_triggered);
}

// --- tracking ---

TEST_F(WeddingShow, WavesFarewellWithinTwoSecondsOfLosingTheFace) {
  Force("TRACKING");
  EXPECT_EQ(TicksTo("FAREWELL", 100), 75) << "1.5 s";
}

TEST_F(WeddingShow, PosesForAPhotoWithinTwentyTicksOfAHeart) {
  Track();
  int ticks = 0;
  while (state() == "TRACKING" && ticks < 20) {
    Gesture("heart");
    TickWithFace(1);
    ++ticks;
  }
  EXPECT_EQ(state(), "PHOTO_POSING");
}

TEST_F(WeddingShow, FollowsAFaceAndNeverJumpsInATick) {
  Track();
  Gaze before = data().motion.look_at_target;
  EXPECT_EQ(before, Gaze{}) << "straight ahead";
  for (int i = 0; i < 10; ++i) {
    TickWithFace(1, {0.2, 0.8});
    const Gaze gaze = data().motion.look_at_target;
    EXPECT_GT(gaze.x, 0.2);
    EXPECT_LT(gaze.y, 0.8);
    EXPECT_LE(std::abs(gaze.x - before.x), 0.3 * 0.3 + 1e-9);
    before = gaze;
  }
  EXPECT_LT(before.x, 0.5);
  EXPECT_GT(before.y, 0.5);
}

TEST_F(WeddingShow, DoesNotReachTheEdgeInOneStep) {
  Track();
  TickWithFace(1, {0.0, 0.5});
  EXPECT_GT(data().motion.look_at_target.x, 0);
}

// --- photo ---

TEST_F(WeddingShow, ShowsAHeartForAHeartAndConfirmsFirst) {
  Track();
  Gesture("heart");
  Tick();
  ASSERT_EQ(state(), "PHOTO_POSING");
  EXPECT_EQ(data().motion.target_pose, "heart");
  EXPECT_EQ(script_.sounds.back(), "photo_confirm");
}

TEST_F(WeddingShow, PosesAfterTheConfirmation) {
  Force("PHOTO_POSING");
  Tick(Ticks(Milliseconds(1200)));
  EXPECT_EQ(state(), "PHOTO_POSING");
  EXPECT_THAT(script_.sounds, ElementsAre("photo_confirm")) << "no countdown before 2.5 s";
  Tick(Ticks(Milliseconds(1300)));
  EXPECT_THAT(script_.sounds, ElementsAre("photo_confirm", "countdown"));
}

TEST_F(WeddingShow, IsBackInTrackingAfterAPhotoOfSixSeconds) {
  Track();
  Gesture("heart");
  Tick();
  const int ticks = TicksToWithFace("TRACKING", 450);
  EXPECT_EQ(ticks, 300) << "6.0 s, not a tick more";
  EXPECT_EQ(script_.photos, 1);
  EXPECT_THAT(script_.sounds, ElementsAre("greeting", "photo_confirm", "countdown", "shutter",
                                          "photo_done", "greeting"));
  EXPECT_THAT(script_.poses, ElementsAre("neutral", "heart", "neutral"));
}

// --- farewell and idle ---

TEST_F(WeddingShow, WavesAndSpeaksFarewellAndIsInIdleWithinThreeSeconds) {
  Force("FAREWELL");
  Tick();
  EXPECT_EQ(data().motion.target_pose, "wave");
  EXPECT_EQ(script_.sounds.back(), "farewell");
  EXPECT_EQ(TicksTo("IDLE", 150), 99) << "2.0 s";
  EXPECT_EQ(data().motion.target_pose, "neutral");
}

TEST_F(WeddingShow, StandsNeutralInIdleAndLooksAboutALittle) {
  Tick(250);
  EXPECT_EQ(state(), "IDLE");
  EXPECT_THAT(script_.poses, ElementsAre("neutral"));
  double least = 1;
  double most = 0;
  for (const Gaze& gaze : script_.gazes) {
    least = std::min(least, gaze.x);
    most = std::max(most, gaze.x);
  }
  EXPECT_NEAR(least, 0.5 - 0.035, 0.001);
  EXPECT_NEAR(most, 0.5 + 0.035, 0.001);
  EXPECT_EQ(script_.gazes.size(), 250) << "each tick";
}

}  // namespace musher::wedding::acceptance_test
