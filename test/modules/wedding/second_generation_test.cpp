// The second generation's action packs, its observing IDLE, its requested gaze and its videos.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "musher/test/modules/wedding/show_rig.hpp"

namespace musher::wedding::second_generation_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

ShowConfig SecondConfig(std::uint64_t seed = 1) {
  ShowConfig config;
  config.search.emplace();
  config.interview.emplace();
  config.interview->unasked = false;
  config.actions.emplace();
  config.actions->seed = seed;
  return config;
}

class SecondShow : public ShowRig {
 protected:
  void SetUp() override { Begin(SecondConfig()); }

  int TicksToMotion(std::string_view motion, int most) {
    for (int i = 1; i <= most; ++i) {
      Tick();
      if (!script_.motions.empty() && script_.motions.back() == motion) return i;
    }
    return -1;
  }
  void ToObserve() { ASSERT_GT(TicksToMotion("stop", Ticks(Milliseconds(25'000))), 0); }
  void ToTracking() {
    Command("tracking");
    Face();
    Tick();
    ASSERT_EQ(state(), "TRACKING");
  }
};

// It published scan_search to its end, also while it followed a face.
TEST_F(SecondShow, SearchTracksTheFaceThatItSeesAndScansWithoutOne) {
  Command("search");
  ASSERT_GT(TicksToMotion("scan_search", 3), 0);
  ASSERT_EQ(state(), "SEARCH");
  Face();
  EXPECT_GT(TicksToMotion("track_face", 3), 0);
  EXPECT_EQ(state(), "SEARCH");
  EXPECT_GT(TicksToMotion("scan_search", Ticks(Milliseconds(2000))), 0) << "it is gone";
  EXPECT_EQ(state(), "SEARCH");
}

TEST_F(SecondShow, IdleSwaysForTenToTwentySecondsThenObservesForThreeToFive) {
  std::set<int> active;
  for (int round = 0; round < 20; ++round) {
    const int moved = TicksToMotion("stop", Ticks(Milliseconds(25'000)));
    const bool greeted = std::ranges::count(script_.motions, "wave_greet") > 0;
    if (!greeted && round > 0) {
      EXPECT_GE(moved, Ticks(Milliseconds(9'900))) << round;
      EXPECT_LE(moved, Ticks(Milliseconds(20'100))) << round;
      active.insert(moved);
    }
    script_.motions.clear();
    int observed = 0;
    while (script_.motions.empty() && observed < 1000) {
      Tick();
      ++observed;
    }
    EXPECT_GE(observed, Ticks(Milliseconds(2'900))) << round;
    EXPECT_LE(observed, Ticks(Milliseconds(5'100))) << round;
  }
  EXPECT_GT(active.size(), 5U) << "the times are drawn";
  EXPECT_EQ(state(), "IDLE");
}

TEST_F(SecondShow, IdleGreetsWithAWaveInAboutThreeOfTenRounds) {
  int rounds = 0;
  int greetings = 0;
  for (int i = 0; i < Ticks(Milliseconds(4'000'000)); ++i) {
    Tick();
    for (const std::string& motion : script_.motions) {
      rounds += motion == "stop" ? 1 : 0;
      greetings += motion == "wave_greet" ? 1 : 0;
    }
    script_.motions.clear();
  }
  EXPECT_GT(rounds, 150);
  EXPECT_NEAR(static_cast<double>(greetings) / rounds, 0.3, 0.1);
  EXPECT_THAT(script_.poses, Contains("wave_start"));
}

TEST_F(SecondShow, AFaceCountsOnlyWhileItObserves) {
  TickWithFace(Ticks(Milliseconds(5000)));
  EXPECT_EQ(state(), "IDLE");
  ToObserve();
  EXPECT_NEAR(TicksToWithFace("SEARCH", 100), Ticks(Milliseconds(500)), 2);
}

TEST_F(SecondShow, AFaceThatIsUnseenForLongerThanTwoTenthsOfASecondBeginsAgain) {
  ToObserve();
  TickWithFace(Ticks(Milliseconds(400)));
  Tick(Ticks(Milliseconds(300)));
  EXPECT_NEAR(TicksToWithFace("SEARCH", 100), Ticks(Milliseconds(500)), 2);
}

TEST_F(SecondShow, AnotherFaceBeginsAgain) {
  ToObserve();
  TickWithFace(Ticks(Milliseconds(400)), {0.2, 0.5});
  EXPECT_NEAR(TicksToWithFace("SEARCH", 100, {0.8, 0.5}), Ticks(Milliseconds(500)), 2);
}

TEST_F(SecondShow, EachStateHasItsPack) {
  Command("search");
  Tick();
  ASSERT_EQ(state(), "SEARCH");
  EXPECT_EQ(script_.motions.back(), "scan_search");
  ToTracking();
  EXPECT_EQ(script_.motions.back(), "track_face");
  Command("interview");
  Face();
  Tick();
  ASSERT_EQ(state(), "INTERVIEW");
  EXPECT_EQ(script_.poses.back(), "mic_hold");
  EXPECT_EQ(script_.motions.back(), "track_face");
  TooClose(true);
  Tick();
  EXPECT_EQ(script_.poses.back(), "neutral");
  EXPECT_EQ(script_.motions.back(), "stop");
}

TEST_F(SecondShow, APhotoHasItsOwnPoseAndNoMotion) {
  ToTracking();
  Command("photo");
  Face();
  Tick();
  ASSERT_EQ(state(), "PHOTO_POSING");
  EXPECT_EQ(script_.poses.back(), "thumbs_up");
  EXPECT_EQ(script_.motions.back(), "stop");
}

TEST_F(SecondShow, TrackingGreetsByItsPackOnceAfterTwoSecondsAndAgainAfterFifteenToTwentyFive) {
  ToTracking();
  EXPECT_THAT(script_.sounds, IsEmpty());
  TickWithFace(Ticks(Milliseconds(2100)));
  EXPECT_THAT(script_.sounds, ElementsAre("greeting_hello"));
  TickWithFace(Ticks(Milliseconds(14'800)));
  EXPECT_THAT(script_.sounds, ElementsAre("greeting_hello"));
  TickWithFace(Ticks(Milliseconds(10'500)));
  EXPECT_EQ(script_.sounds.size(), 2U);
}

TEST_F(SecondShow, AShuffledBagDrawsEachSoundOnceAndNoneTwiceInARow) {
  constexpr std::array<std::string_view, 4> kSounds = {"a", "b", "c", "d"};
  std::mt19937_64 random(7);
  ShuffledBag bag;
  std::string_view last;
  for (int round = 0; round < 100; ++round) {
    std::set<std::string_view> drawn;
    for (std::size_t i = 0; i < kSounds.size(); ++i) {
      const std::string_view sound = bag.Draw(kSounds, random);
      EXPECT_NE(sound, last);
      last = sound;
      drawn.insert(sound);
    }
    EXPECT_EQ(drawn.size(), kSounds.size());
  }
}

TEST_F(SecondShow, APausedShowMovesNothingAndContinuesWithItsPack) {
  Tick(50);
  machine_->Pause();
  show_->Pause(now_);
  EXPECT_EQ(script_.motions.back(), "stop");
  show_->Resume(now_);
  Tick(2);
  EXPECT_EQ(script_.motions.back(), "sway_normal");
}

TEST_F(SecondShow, LooksAtTheRequestedPointAsLongAsItIsValid) {
  ToTracking();
  show_->OnLookAt({0.9, 0.1}, now_);
  TickWithFace(Ticks(Milliseconds(1000)), {0.1, 0.9});
  EXPECT_NEAR(data().motion.look_at_target.x, 0.9, 0.02);
  TickWithFace(Ticks(Milliseconds(2000)), {0.1, 0.9});
  EXPECT_NEAR(data().motion.look_at_target.x, 0.1, 0.02);
  show_->OnLookAt({320, 240}, now_);
  ASSERT_EQ(script_.log.size(), 1U);
  EXPECT_THAT(script_.log[0],
              ::testing::HasSubstr("set_look_at (320, 240, 0): x and y are 0 to 1"));
}

TEST_F(SecondShow, RecordsAVideoOfAnInterviewAlsoWhenItIsBrokenOff) {
  ShowConfig config = SecondConfig();
  config.interview->video = true;
  Begin(config);
  ToTracking();
  Command("interview");
  Face();
  Tick();
  ASSERT_EQ(state(), "INTERVIEW");
  EXPECT_THAT(script_.videos, ElementsAre(true));
  TooClose(true);
  Tick();
  EXPECT_THAT(script_.videos, ElementsAre(true, false));
}

TEST_F(SecondShow, ARecordingReplaysIdentically) {
  for (int i = 0; i < Ticks(Milliseconds(120'000)); ++i) {
    if (i % 700 > 300) Face();
    if (i == 900) show_->OnCamera(640, 480, 500, now_);
    Tick();
  }
  EXPECT_GT(ExpectReplays(SecondConfig()), 3U);
}

class HeadCameraInfo : public ShowRig {
 protected:
  void SetUp() override {
    config_.gaze.camera = Mount::kHead;
    Begin(config_);
  }
  void HeadAhead() { show_->OnJointStates({}, std::vector<double>(kJointCount, 0.0), {}, now_); }
  ShowConfig config_;
};

TEST_F(HeadCameraInfo, TheCamerasOwnOpeningTakesThePlaceOfTheConfiguredOne) {
  HeadAhead();
  Face({1.0, 0.5});
  Tick();
  const double configured = data().perception.face_gaze.x;
  show_->OnCamera(640, 480, 1000, now_);  // a narrower one
  HeadAhead();
  Face({1.0, 0.5});
  Tick();
  const double expected = 0.5 + std::atan(0.32) / (2 * config_.gaze.yaw_limit_rad);
  EXPECT_NEAR(data().perception.face_gaze.x, expected, 1e-9);
  EXPECT_LT(data().perception.face_gaze.x, configured);
}

TEST_F(HeadCameraInfo, AnImpossibleCameraIsRefused) {
  const double nan = std::nan("");
  for (const double focal : {0.0, -1.0, nan, 1e-9}) show_->OnCamera(640, 480, focal, now_);
  show_->OnCamera(0, 480, 500, now_);
  EXPECT_FALSE(script_.log.empty());
  HeadAhead();
  Face({0.75, 0.5});
  Tick();
  EXPECT_TRUE(std::isfinite(data().perception.face_gaze.x));
}

}  // namespace musher::wedding::second_generation_test
