// Invariants of the show beyond the acceptance table: faults of the robot it models that it does
// not have.

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <string>

#include "musher/behavior/fsm/snapshot.hpp"
#include "musher/test/modules/wedding/show_rig.hpp"

namespace musher::wedding::show_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class ShowTest : public ShowRig {};

// --- perception ages by the time, not by the tick ---

TEST_F(ShowTest, AcceptsAPersonWhoPublishesOnceASecond) {
  for (int second = 0; second < 5; ++second) {
    Face();
    Tick(50);
    EXPECT_EQ(state(), "TRACKING") << second;
  }
  EXPECT_EQ(TicksTo("FAREWELL", 100), 25) << "1.5 s after the last face";
}

TEST_F(ShowTest, LosesAFaceAfterTheSameTimeAtEveryRate) {
  for (const int period_ms : {1, 20, 100, 250}) {
    Begin({}, Milliseconds(period_ms));
    Track();
    const Time seen = now_ - step_;
    ASSERT_GT(TicksTo("FAREWELL", 2000), 0);
    EXPECT_GE(now_ - seen, Milliseconds(1500)) << period_ms;
    EXPECT_LE(now_ - seen, Milliseconds(1500 + period_ms)) << period_ms;
  }
}

TEST_F(ShowTest, FollowsTheSamePathAtEveryRate) {
  std::vector<double> reached;
  for (const int period_ms : {5, 20, 40}) {
    Begin({}, Milliseconds(period_ms));
    Track();
    TickWithFace(Ticks(Milliseconds(200)), {0.9, 0.5});
    reached.push_back(data().motion.look_at_target.x);
  }
  EXPECT_NEAR(reached[0], reached[1], 1e-9);
  EXPECT_NEAR(reached[2], reached[1], 1e-9);
}

TEST_F(ShowTest, DoesNotJumpAfterALongPause) {
  Track();
  now_ += std::chrono::hours(1);
  TickWithFace(1, {1, 0.5});
  EXPECT_LT(data().motion.look_at_target.x, 0.95);
}

TEST_F(ShowTest, ForgetsWhatItSawWhenTimeGoesBack) {
  Track();
  now_ -= Milliseconds(900);
  Tick();
  EXPECT_FALSE(data().perception.face_detected);
}

// --- safety ---

TEST_F(ShowTest, RestartsTheTimeEachTimeAGuestIsTooClose) {
  TooClose(true);
  Tick();
  TooClose(false);
  Tick(90);
  TooClose(true);
  Tick();
  TooClose(false);
  EXPECT_EQ(TicksTo("IDLE", 150), 100);
  EXPECT_THAT(script_.sounds, ElementsAre("too_close")) << "asked once";
}

TEST_F(ShowTest, StaysInSafeStopWithoutADetectorUntilOneReportsThatNoGuestIsTooClose) {
  TooClose(true);
  EXPECT_EQ(TicksTo("SAFE_STOP", 1), 1);
  Tick(50 * 60);
  EXPECT_EQ(state(), "SAFE_STOP") << "for a minute";
  TooClose(false);
  EXPECT_EQ(TicksTo("IDLE", 150), 100);
}

TEST_F(ShowTest, RemembersThroughAPauseThatAGuestIsTooClose) {
  TooClose(true);
  Tick();
  show_->Pause(now_);
  show_->Resume(now_);
  EXPECT_EQ(TicksTo("SAFE_STOP", 1), 1);
}

TEST_F(ShowTest, HandlesStopInSafeStopOnlyOnceNoGuestIsTooClose) {
  TooClose(true);
  Tick();
  Command("stop");
  Tick();
  EXPECT_EQ(state(), "SAFE_STOP");
  EXPECT_EQ(machine_->counts().unhandled, 1U);
  TooClose(false);
  Tick();
  Command("stop");
  Tick();
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(ShowTest, StandsNeutralAndLooksAheadInSafeStop) {
  Track();
  TickWithFace(20, {0.1, 0.1});
  Gesture("v");
  TickWithFace(1, {0.1, 0.1});
  ASSERT_EQ(script_.poses.back(), "v_sign");
  TooClose(true);
  Tick();
  EXPECT_EQ(script_.poses.back(), "neutral");
  EXPECT_EQ(script_.gazes.back(), Gaze{});
}

// --- photo ---

TEST_F(ShowTest, ShowsAVForAVAndAThumbWithoutAGesture) {
  Track();
  Gesture("V");
  Tick();
  EXPECT_EQ(data().motion.target_pose, "v_sign");
  Begin({});
  Command("photo");
  Tick();
  EXPECT_EQ(data().motion.target_pose, "thumbs_up");
}

TEST_F(ShowTest, TakesOnePhotoForAHeartThatIsHeldForTwentySeconds) {
  Track();
  for (int i = 0; i < 1000; ++i) {
    Gesture("heart");
    TickWithFace(1);
  }
  EXPECT_EQ(script_.photos, 1);
  EXPECT_EQ(state(), "TRACKING");
}

TEST_F(ShowTest, TakesAnotherPhotoForAnotherHeart) {
  Track();
  Gesture("heart");
  ASSERT_GT(TicksToWithFace("PHOTO_POSING", 5), 0);
  ASSERT_GT(TicksToWithFace("TRACKING", 400), 0);
  Gesture("none");
  TickWithFace(1);
  EXPECT_EQ(state(), "TRACKING");
  Gesture("heart");
  TickWithFace(1);
  EXPECT_EQ(state(), "PHOTO_POSING");
}

TEST_F(ShowTest, DoesNothingForAnOkOrAnUnsureGesture) {
  Track();
  Gesture("ok");
  TickWithFace(5);
  EXPECT_EQ(state(), "TRACKING");
  ShowConfig config;
  config.tracking.gesture_threshold = 0.8;
  Begin(config);
  Track();
  Gesture("heart");
  TickWithFace(5);
  EXPECT_EQ(state(), "TRACKING") << "surer than the threshold";
}

TEST_F(ShowTest, CatchesUpWithAllSoundsInTheirOrderAfterALateTick) {
  Force("PHOTO_POSING");
  Tick();
  now_ += Milliseconds(7000);
  Tick();
  EXPECT_THAT(script_.sounds,
              ElementsAre("photo_confirm", "countdown", "shutter", "photo_done", "greeting"));
  EXPECT_EQ(script_.photos, 1);
  EXPECT_EQ(state(), "TRACKING");
}

TEST_F(ShowTest, TakesNoPhotoWhenItIsStoppedBeforeTheShutter) {
  Force("PHOTO_POSING");
  Tick(200);
  Command("stop");
  Tick(300);
  EXPECT_EQ(script_.photos, 0);
  EXPECT_EQ(script_.poses.back(), "neutral");
}

// --- commands ---

TEST_F(ShowTest, HandlesCommandsOneATickInOrder) {
  Command("photo");
  Command("tracking");
  Tick();
  EXPECT_EQ(state(), "PHOTO_POSING");
  Tick();
  EXPECT_EQ(state(), "TRACKING");
}

TEST_F(ShowTest, AcceptsCommandsInAnyCaseAndWithBlanks) {
  Command("  Photo\n");
  Tick();
  EXPECT_EQ(state(), "PHOTO_POSING");
  Command("RESET");
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(ShowTest, SurvivesTenThousandCommandsAtOnceAndHandlesTheStopAmongThem) {
  for (int i = 0; i < 10'000; ++i) Command("photo");
  Command("stop");
  Tick();
  EXPECT_EQ(state(), "IDLE") << "stop goes before all that wait";
  EXPECT_EQ(machine_->waiting_commands(), 0);
  EXPECT_EQ(machine_->counts().refused + machine_->counts().superseded, 10'000);
  EXPECT_THAT(script_.log, ::testing::SizeIs(1));
  Tick(150);
  EXPECT_THAT(script_.log.back(), HasSubstr("(and 9966 more)"));
}

TEST_F(ShowTest, TakesOnePhotoForTenThousandCommands) {
  for (int i = 0; i < 10'000; ++i) Command("photo");
  Tick(500);
  EXPECT_EQ(script_.photos, 1);
}

TEST_F(ShowTest, LogsUnknownCommands) {
  Command("dance");
  Command("search");
  Tick();
  EXPECT_EQ(state(), "IDLE");
  EXPECT_THAT(script_.log, ElementsAre("command 'dance': not in this show"));
  EXPECT_EQ(show_->faults(), 2);
}

TEST_F(ShowTest, HandlesVoiceCommands) {
  show_->OnVoiceCommand("photo", now_);
  Tick();
  EXPECT_EQ(state(), "PHOTO_POSING");
  EXPECT_EQ(data().audio.voice_command, "photo");
  show_->OnVoiceCommand("none", now_);
  show_->OnVoiceCommand("stop", now_);
  Tick();
  EXPECT_EQ(state(), "IDLE");
  show_->OnVoiceCommand("abracadabra", now_);
  show_->OnVoiceCommand("interview", now_);
  EXPECT_THAT(script_.log,
              ElementsAre(HasSubstr("voice command 'abracadabra'"), HasSubstr("'interview'")));
}

// --- rest ---

TEST_F(ShowTest, RestsNeutralAndContinuesFromIdle) {
  Track();
  Gesture("heart");
  TickWithFace(10, {0.9, 0.5});
  ASSERT_EQ(state(), "PHOTO_POSING");
  show_->Pause(now_);
  EXPECT_EQ(state(), "IDLE");
  EXPECT_EQ(script_.poses.back(), "neutral");
  EXPECT_EQ(script_.gazes.back(), Gaze{});
  Command("photo");
  EXPECT_THAT(script_.log, ElementsAre("command photo is refused: the show is paused"));
  show_->Resume(now_);
  Tick(2);
  EXPECT_EQ(state(), "IDLE") << "what was seen before does not count any more";
  EXPECT_EQ(script_.poses.back(), "neutral");
  EXPECT_EQ(script_.photos, 0);
}

TEST_F(ShowTest, PublishesNothingForARobotThatMustNotBeMoved) {
  Track();
  TickWithFace(10, {0.9, 0.5});
  const std::size_t gazes = script_.gazes.size();
  const std::size_t poses = script_.poses.size();
  show_->Pause(now_, true);
  EXPECT_EQ(script_.gazes.size(), gazes);
  EXPECT_EQ(script_.poses.size(), poses);
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(ShowTest, PublishesItsPoseAgainForARestartedMotionAdapter) {
  Tick();
  show_->Pause(now_);
  show_->Resume(now_);
  Tick();
  EXPECT_THAT(script_.poses, ElementsAre("neutral", "neutral", "neutral"));
}

TEST_F(ShowTest, ContinuesFromASavedPhotoInAnotherProcess) {
  Track();
  Gesture("heart");
  TickWithFace(150);
  ASSERT_EQ(script_.sounds.back(), "countdown");
  const Gaze gaze = data().motion.look_at_target;
  const Result<fsm::Snapshot> saved = machine_->Save();
  ASSERT_TRUE(saved) << saved.error().message;

  Begin({});
  ASSERT_TRUE(machine_->Stop());
  ASSERT_THAT(machine_->Restore(saved.value(), now_), IsEmpty());
  EXPECT_EQ(state(), "PHOTO_POSING");
  EXPECT_EQ(data().motion.look_at_target, gaze);
  EXPECT_EQ(TicksToWithFace("TRACKING", 400), 151) << "6.0 s in all";
  EXPECT_THAT(script_.sounds, ElementsAre("shutter", "photo_done", "greeting"));
  EXPECT_THAT(script_.poses, ElementsAre("heart", "neutral"));
}

// --- guests ---

TEST_F(ShowTest, WaitsForAFaceToStayIfConfigured) {
  ShowConfig config;
  config.idle.confirm = Milliseconds(300);
  Begin(config);
  EXPECT_EQ(TicksToWithFace("TRACKING", 20), 16);
}

TEST_F(ShowTest, ReturnsToIdleFromEveryStateWhenLeftAlone) {
  for (const char* from : {"IDLE", "TRACKING", "PHOTO_POSING", "FAREWELL", "SAFE_STOP"}) {
    Force(from);
    Tick(Ticks(Milliseconds(10'000)));
    EXPECT_EQ(state(), "IDLE") << from;
  }
}

}  // namespace musher::wedding::show_test
