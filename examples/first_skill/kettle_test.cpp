// Tests the skill without a robot, in virtual time.

#include <gtest/gtest.h>

#include <vector>

#include "kettle.hpp"
#include "musher/behavior/skill/manager.hpp"

class AKettle : public ::testing::Test {
 protected:
  AKettle() : skills_(Skills(kettle_)) {}

  static std::vector<skill::Entry> Skills(Kettle& kettle) {
    skill::Registry registry;
    EXPECT_TRUE(registry.Add<Heat>("heat", kettle));
    return registry.All();
  }
  void Wait(musher::Duration time) {
    for (const musher::Time end = now_ + time; now_ < end; now_ += kStep) {
      kettle_.Advance(kStep);
      skills_.RunOnce(now_);
    }
  }
  const skill::Feedback& Feedback() const { return skills_.Find("heat")->feedback(); }

  static constexpr musher::Duration kStep = std::chrono::milliseconds(100);
  Kettle kettle_;
  skill::Manager skills_;
  musher::Time now_;
};

TEST_F(AKettle, HeatsItsWaterInFiveSeconds) {
  ASSERT_TRUE(skills_.Start("heat"));
  Wait(std::chrono::seconds(3));
  EXPECT_EQ(Feedback().status, skill::Status::kProcessing);
  EXPECT_NEAR(Feedback().progress, 60, 5);
  Wait(std::chrono::seconds(3));
  EXPECT_EQ(Feedback().status, skill::Status::kCompleted);
  EXPECT_FALSE(kettle_.heats);
}

TEST_F(AKettle, FailsWithoutWaterAndDoesNotHeat) {
  kettle_.water_l = 0;
  ASSERT_TRUE(skills_.Start("heat"));
  Wait(std::chrono::seconds(1));
  EXPECT_EQ(Feedback().status, skill::Status::kFailed);
  EXPECT_EQ(Feedback().message, "less than 0.2 l of water");
  EXPECT_FALSE(kettle_.heats);
}

TEST_F(AKettle, DoesNotHeatAfterACancellationOrDuringAPause) {
  ASSERT_TRUE(skills_.Start("heat"));
  Wait(std::chrono::seconds(1));
  EXPECT_TRUE(kettle_.heats);
  skills_.Pause();
  EXPECT_FALSE(kettle_.heats);
  Wait(std::chrono::seconds(1));
  EXPECT_TRUE(kettle_.heats);
  ASSERT_TRUE(skills_.Cancel("heat", "enough"));
  Wait(std::chrono::seconds(1));
  EXPECT_FALSE(kettle_.heats);
  EXPECT_EQ(Feedback().status, skill::Status::kCancelled);
}
