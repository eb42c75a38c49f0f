// The effect of a stop command while a guest stands before the robot.

#include <gmock/gmock.h>

#include <string>

#include "musher/test/modules/wedding/show_rig.hpp"

namespace musher::wedding::show_stop_test {

using ::testing::IsEmpty;

class StoppedShow : public ShowRig {
 protected:
  void SetUp() override {
    Begin({});
    Track();
    script_ = {};
  }
  // Of the largest face; the target is published with it.
  void Id(int id) {
    show_->OnFaces(
        R"({"faces": [{"area": 0.1, "is_frontal": true, "face_id": )" + std::to_string(id) + "}]}",
        now_);
  }
};

TEST_F(StoppedShow, StaysInIdleInFrontOfTheFaceItWasStoppedBefore) {
  for (const char* word : {"stop", "idle"}) {
    Command("tracking");
    TickWithFace(1);
    script_ = {};
    Command(word);
    TickWithFace(2);
    EXPECT_EQ(state(), "IDLE") << word << ": after two ticks";
    TickWithFace(500);
    EXPECT_EQ(state(), "IDLE") << word << ": for ten seconds";
    EXPECT_THAT(script_.sounds, IsEmpty()) << word;
  }
}

TEST_F(StoppedShow, StaysInIdleWhenItIsStoppedByVoiceOrService) {
  show_->OnVoiceCommand("stop", now_);
  TickWithFace(100);
  EXPECT_EQ(state(), "IDLE");
  Command("tracking");
  TickWithFace(1);
  ASSERT_EQ(state(), "TRACKING");
  Force("IDLE");
  TickWithFace(100);
  EXPECT_EQ(state(), "IDLE");
}

// A photo was begun when the computer was opened, by a command that had waited meanwhile.
TEST_F(StoppedShow, BeginsNothingByACommandThatMayBeLateAndIsStoppedByOne) {
  const Result<> late = Error{kCodeStateInvalid, "it may be 9 s old"};
  show_->OnCommand("photo", now_, late);
  show_->OnVoiceCommand("photo", now_, late);
  TickWithFace(5);
  EXPECT_EQ(state(), "TRACKING");
  ASSERT_FALSE(script_.log.empty());
  EXPECT_THAT(script_.log.back(), ::testing::HasSubstr("it may be 9 s old"));
  show_->OnCommand("stop", now_, late);
  TickWithFace(2);
  EXPECT_EQ(state(), "IDLE");
  show_->OnCommand("tracking", now_, late);
  TickWithFace(5);
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(StoppedShow, GreetsTheFirstGuestWhoComesAfterTheFaceIsLost) {
  Command("stop");
  TickWithFace(50);
  Tick(Ticks(Milliseconds(1600)));
  EXPECT_EQ(TicksToWithFace("TRACKING", 5), 1);
}

TEST_F(StoppedShow, GreetsAnotherGuestWhoComesMeanwhile) {
  Id(3);
  TickWithFace(1);
  Command("stop");
  TickWithFace(20);
  Id(-1);  // turns away for a moment
  TickWithFace(20);
  Id(3);
  TickWithFace(20);
  EXPECT_EQ(state(), "IDLE");
  Id(4);
  TickWithFace(1);
  EXPECT_EQ(state(), "TRACKING");
}

TEST_F(StoppedShow, GreetsAGuestWhoComesWhenNoneStoodThere) {
  Tick(Ticks(Milliseconds(5000)));
  ASSERT_EQ(state(), "IDLE");
  Command("stop");
  Tick();
  EXPECT_EQ(TicksToWithFace("TRACKING", 5), 1);
  EXPECT_THAT(script_.log, IsEmpty()) << "a stop in IDLE is handled";
}

TEST_F(StoppedShow, TracksTheSameFaceAgainByCommand) {
  Command("stop");
  TickWithFace(10);
  Command("tracking");
  TickWithFace(1);
  EXPECT_EQ(state(), "TRACKING");
  Command("stop");
  TickWithFace(10);
  ASSERT_EQ(state(), "IDLE");
  Command("reset");
  TickWithFace(1);
  EXPECT_EQ(state(), "TRACKING");
}

TEST_F(StoppedShow, StaysStoppedWhenAGuestWasTooCloseMeanwhile) {
  Command("stop");
  TickWithFace(10);
  TooClose(true);
  TickWithFace(10);
  ASSERT_EQ(state(), "SAFE_STOP");
  TooClose(false);
  TickWithFace(300);
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(StoppedShow, IsStoppedByACommandThatComesInIdleBeforeTheFaceIsConfirmed) {
  ShowConfig config;
  config.idle.confirm = Milliseconds(300);
  Begin(config);
  TickWithFace(10);
  Command("stop");
  TickWithFace(100);
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(StoppedShow, TakesThePhotoThatASafetyStopInterrupted) {
  Track();
  Gesture("heart");
  Face();
  Tick();
  ASSERT_EQ(state(), "PHOTO_POSING");
  TooClose(true);
  Tick();
  ASSERT_EQ(state(), "SAFE_STOP");
  TooClose(false);
  int photos = 0;
  for (int i = 0; i < Ticks(Milliseconds(12000)); ++i) {
    Face();
    Gesture("heart");  // it is held all the time
    Tick();
    photos += script_.photos;
    script_.photos = 0;
  }
  EXPECT_EQ(photos, 1);
}

TEST_F(StoppedShow, TakesNoSecondPhotoWhenASafetyStopComesAfterTheShutter) {
  Track();
  Gesture("heart");
  Face();
  Tick();
  ASSERT_EQ(state(), "PHOTO_POSING");
  while (script_.photos == 0) Tick();
  Gesture("heart");
  TooClose(true);
  Tick();
  TooClose(false);
  for (int i = 0; i < Ticks(Milliseconds(12000)); ++i) {
    Face();
    Gesture("heart");
    Tick();
  }
  EXPECT_EQ(script_.photos, 1);
}

}  // namespace musher::wedding::show_stop_test
