#include "musher/lifecycle/ros2/bond.hpp"

#include <gtest/gtest.h>

namespace musher::bond_test {

using Phase = Bond::Phase;

class ABond : public ::testing::Test {
 protected:
  // Advances time to `end`; returns the number of published heartbeats.
  int Until(Time end) {
    int published = 0;
    while (const auto next = bond_.next()) {
      if (*next > end) break;
      now_ = *next;
      published += bond_.OnTime(now_) ? 1 : 0;
    }
    now_ = end;
    return published;
  }
  bool Receive(const std::string& instance, bool active = true) {
    return bond_.OnHeartbeat({instance, active, Milliseconds(4000)}, now_);
  }

  Bond bond_;
  Time now_{};
};

TEST_F(ABond, SendsAHeartbeatAtOnceAndThenTenInASecond) {
  EXPECT_TRUE(bond_.Start(now_));
  EXPECT_EQ(Until(now_ + Milliseconds(1000)), 10);
  EXPECT_TRUE(bond_.active());
}

TEST_F(ABond, AnswersTheFirstHeartbeatOfTheOtherSideAtOnce) {
  bond_.Start(now_);
  EXPECT_TRUE(Receive("manager"));
  EXPECT_EQ(bond_.phase(), Phase::kFormed);
  EXPECT_FALSE(Receive("manager")) << "then by the period";
}

TEST_F(ABond, SendsAHeartbeatAtOnceWhenAReaderIsMatched) {
  bond_.Start(now_);
  EXPECT_TRUE(bond_.OnReaders(now_));
}

TEST_F(ABond, IsBrokenWhenTheOtherSideIsSilentForItsTimeout) {
  bond_.Start(now_);
  Receive("manager");
  Until(now_ + Milliseconds(3999));
  EXPECT_EQ(bond_.phase(), Phase::kFormed);
  Until(now_ + Milliseconds(1));
  EXPECT_EQ(bond_.phase(), Phase::kBroken);
  EXPECT_FALSE(bond_.active());
  EXPECT_EQ(bond_.next(), std::nullopt) << "it publishes no more";
}

TEST_F(ABond, AcknowledgesTheEndByTheOtherSide) {
  bond_.Start(now_);
  Receive("manager");
  EXPECT_TRUE(Receive("manager", false));
  EXPECT_EQ(bond_.phase(), Phase::kBroken);
  EXPECT_FALSE(Receive("manager", false)) << "once";
}

TEST_F(ABond, IsNotEndedByAnotherInstance) {
  bond_.Start(now_);
  Receive("manager");
  EXPECT_FALSE(Receive("another", false));
  EXPECT_EQ(bond_.phase(), Phase::kFormed);
}

TEST_F(ABond, IsFormedAgainByARestartedManager) {
  bond_.Start(now_);
  Receive("manager");
  Until(now_ + Milliseconds(4000));
  EXPECT_TRUE(Receive("manager again"));
  EXPECT_EQ(bond_.phase(), Phase::kFormed);
}

TEST_F(ABond, PublishesItsEndUntilTheOtherSideHasEndedToo) {
  bond_.Start(now_);
  Receive("manager");
  EXPECT_TRUE(bond_.Stop(now_));
  EXPECT_FALSE(bond_.active());
  EXPECT_EQ(Until(now_ + Milliseconds(250)), 2);
  EXPECT_FALSE(Receive("manager")) << "sent before the other side received the end";
  Receive("manager", false);
  EXPECT_EQ(bond_.phase(), Phase::kOff);
  EXPECT_EQ(bond_.next(), std::nullopt);
}

TEST_F(ABond, DoesNotWaitForALostSide) {
  bond_.Start(now_);
  Receive("manager");
  bond_.Stop(now_);
  Until(now_ + Milliseconds(2000));
  EXPECT_EQ(bond_.phase(), Phase::kOff);
}

TEST_F(ABond, BeginsAgainWithTheNextActivation) {
  bond_.Start(now_);
  Receive("manager");
  bond_.Stop(now_);
  EXPECT_TRUE(bond_.Start(now_));
  EXPECT_EQ(bond_.phase(), Phase::kWaiting);
}

TEST_F(ABond, IsFormedAgainByTheSameManagerAndAnswersItAtOnce) {
  bond_.Start(now_);
  Receive("manager");
  Until(now_ + Milliseconds(4000));
  EXPECT_TRUE(Receive("manager"));
  EXPECT_EQ(bond_.phase(), Phase::kFormed);
}

TEST_F(ABond, IsBrokenAfterTenMinutesThoughTheOtherSideHasALongerTimeout) {
  bond_.Start(now_);
  bond_.OnHeartbeat({"manager", true, std::chrono::hours(5)}, now_);
  Until(now_ + std::chrono::minutes(10) - Milliseconds(1));
  EXPECT_EQ(bond_.phase(), Phase::kFormed);
  Until(now_ + Milliseconds(1));
  EXPECT_EQ(bond_.phase(), Phase::kBroken);
}

TEST_F(ABond, SendsNoHeartbeatBeforeItsPeriod) {
  bond_.Start(now_);
  EXPECT_FALSE(bond_.OnTime(now_ + Milliseconds(99)));
  EXPECT_TRUE(bond_.OnTime(now_ + Milliseconds(100)));
}

TEST_F(ABond, ThatIsOffSendsNothingWhenItIsStopped) {
  EXPECT_FALSE(bond_.Stop(now_));
}

TEST_F(ABond, ThatIsOffSendsNothingWhenAReaderIsMatched) {
  EXPECT_FALSE(bond_.OnReaders(now_));
}

TEST_F(ABond, WaitsAtLeastTwoHundredMillisecondsForTheNextHeartbeat) {
  bond_.Start(now_);
  bond_.OnHeartbeat({"manager", true, Milliseconds(10)}, now_);
  const Time received = now_;
  Until(received + Milliseconds(199));
  EXPECT_EQ(bond_.phase(), Phase::kFormed);
  Until(received + Milliseconds(200));
  EXPECT_EQ(bond_.phase(), Phase::kBroken);
}

TEST_F(ABond, ThatIsBrokenEndsWithoutAHeartbeat) {
  bond_.Start(now_);
  Receive("manager");
  Until(now_ + Milliseconds(4000));
  ASSERT_EQ(bond_.phase(), Phase::kBroken);
  EXPECT_FALSE(bond_.Stop(now_));
  EXPECT_EQ(bond_.phase(), Phase::kOff);
}

}  // namespace musher::bond_test
