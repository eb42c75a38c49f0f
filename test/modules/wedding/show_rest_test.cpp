// The show before its first start, while it is paused, and when it is reset to IDLE.

#include <gmock/gmock.h>

#include <string>

#include "musher/test/modules/wedding/show_rig.hpp"

namespace musher::wedding::show_rest_test {

class RestingShow : public ShowRig {};

TEST_F(RestingShow, RecordsThatAGuestWasTooCloseBeforeTheStart) {
  show_.reset();
  recorder_.reset();
  machine_ = std::make_unique<fsm::Machine>(fsm::Machine::Options{.name = "wedding"});
  show_ = std::make_unique<Show>(ShowConfig{}, script_);
  ASSERT_TRUE(show_->Build(*machine_));
  recording_.clear();
  recorder_ = std::make_unique<fsm::Recorder>(
      *machine_, [this](std::string_view line) { recording_ += line; });
  show_->RecordTo(*recorder_);
  TooClose(true);
  show_->Resume(now_);
  ASSERT_TRUE(machine_->Start(now_));
  Tick(50);
  ASSERT_EQ(state(), "SAFE_STOP");
  ExpectReplays({});
}

TEST_F(RestingShow, DoesNotFillItsHistoryWithPausesInIdle) {
  Track();
  const std::size_t before = machine_->history().size();
  for (int i = 0; i < 40; ++i) {
    machine_->Pause();
    show_->Pause(now_);
    show_->Resume(now_);
    Tick(10);
  }
  EXPECT_EQ(state(), "IDLE");
  EXPECT_EQ(machine_->history().size(), before + 1) << "home from TRACKING, once";
}

TEST_F(RestingShow, AsksAGuestWhoIsTooCloseOnceHoweverOftenItIsReset) {
  TooClose(true);
  Tick(2);
  for (int i = 0; i < 5; ++i) {
    Force("IDLE");
    Tick(5);
  }
  EXPECT_EQ(state(), "SAFE_STOP");
  EXPECT_THAT(script_.sounds, ::testing::ElementsAre("too_close"));
  TooClose(false);
  ASSERT_GT(TicksTo("IDLE", 150), 0);
  TooClose(true);
  Tick();
  EXPECT_THAT(script_.sounds, ::testing::ElementsAre("too_close", "too_close")) << "another time";
}

TEST_F(RestingShow, DropsACommandThatWaitsInIdle) {
  Command("photo");
  show_->Pause(now_);
  show_->Resume(now_);
  Tick(2);
  EXPECT_EQ(state(), "IDLE");
}

}  // namespace musher::wedding::show_rest_test
