// The show's timeout of perception.

#include <gmock/gmock.h>

#include <string>

#include "musher/test/modules/wedding/show_rig.hpp"

namespace musher::wedding::show_blind_test {

using ::testing::IsEmpty;

class BlindShow : public ShowRig {
 protected:
  void SetUp() override {
    config_.perception.blind = Milliseconds(3000);
    Begin(config_);
  }
  ShowConfig config_;
};

TEST_F(BlindShow, StopsOnATimeoutOfPerceptionAndContinuesWhenItIsBack) {
  TooClose(false);
  Command("photo");
  Tick(Ticks(Milliseconds(3000)));
  ASSERT_EQ(state(), "PHOTO_POSING");
  Tick();
  EXPECT_EQ(state(), "SAFE_STOP");
  EXPECT_EQ(machine_->unsafe(), "no detector publishes");
  EXPECT_EQ(script_.poses.back(), "neutral");
  EXPECT_EQ(data().audio.current_speech, "countdown") << "no guest is asked to step back";
  Command("stop");
  Tick(50 * 60);
  EXPECT_EQ(state(), "SAFE_STOP") << "for a minute, whatever is commanded";
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(state(), "SAFE_STOP") << i;
    TooClose(false);
    Tick();
  }
  EXPECT_EQ(state(), "IDLE") << "2.0 s";
}

TEST_F(BlindShow, StopsWithoutAFirstMessage) {
  EXPECT_EQ(TicksTo("SAFE_STOP", 1000), Ticks(Milliseconds(3000)) + 2) << "from its first tick";
}

TEST_F(BlindShow, ContinuesWhileAnyOfTheThreeTopicsPublishes) {
  for (const int kind : {0, 1, 2}) {
    for (int second = 0; second < 10; ++second) {
      if (kind == 0) Face();
      if (kind == 1) TooClose(false);
      if (kind == 2) show_->OnFaces(R"({"faces": []})", now_);
      Tick(Ticks(Milliseconds(1000)));
      EXPECT_NE(state(), "SAFE_STOP") << kind;
    }
  }
}

TEST_F(BlindShow, IsNotKeptGoingByRefusedInput) {
  for (int i = 0; i < 200; ++i) {
    Face({7, 7});
    show_->OnFaces("{", now_);
    Tick();
  }
  EXPECT_EQ(state(), "SAFE_STOP");
}

TEST_F(BlindShow, StartsTheTimeoutAgainAfterAPause) {
  Tick(Ticks(Milliseconds(2000)));
  show_->Pause(now_);
  now_ += std::chrono::hours(1);
  show_->Resume(now_);
  EXPECT_EQ(TicksTo("SAFE_STOP", 1000), Ticks(Milliseconds(3000)) + 2);
}

TEST_F(BlindShow, ContinuesForAnHourWithoutABlindTimeout) {
  Begin({}, Milliseconds(100));
  Tick(36'000);
  EXPECT_EQ(state(), "IDLE");
  EXPECT_THAT(script_.log, IsEmpty());
}

}  // namespace musher::wedding::show_blind_test
