#include "musher/lifecycle/bond.hpp"

#include <gtest/gtest.h>

namespace musher::bond_test {

using Phase = Bond::Phase;

class ABond : public ::testing::Test {
 protected:
  // Lets time go by until `end`; gives how many heartbeats were published.
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
  bool Hear(const std::string& instance, bool active = true) {
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
  EXPECT_TRUE(Hear("manager"));
  EXPECT_EQ(bond_.phase(), Phase::kFormed);
  EXPECT_FALSE(Hear("manager")) << "then by the clock";
}

TEST_F(ABond, SendsAHeartbeatAtOnceWhenTheOtherSideShowsItself) {
  bond_.Start(now_);
  EXPECT_TRUE(bond_.OnReaders(now_));
}

TEST_F(ABond, IsBrokenWhenTheOtherSideIsSilentForItsTimeout) {
  bond_.Start(now_);
  Hear("manager");
  Until(now_ + Milliseconds(3999));
  EXPECT_EQ(bond_.phase(), Phase::kFormed);
  Until(now_ + Milliseconds(1));
  EXPECT_EQ(bond_.phase(), Phase::kBroken);
  EXPECT_FALSE(bond_.active());
  EXPECT_EQ(bond_.next(), std::nullopt) << "nothing more to say";
}

TEST_F(ABond, AcknowledgesTheEndByTheOtherSide) {
  bond_.Start(now_);
  Hear("manager");
  EXPECT_TRUE(Hear("manager", false));
  EXPECT_EQ(bond_.phase(), Phase::kBroken);
  EXPECT_FALSE(Hear("manager", false)) << "once";
}

TEST_F(ABond, IsNotEndedByAnotherSideThanItsOwn) {
  bond_.Start(now_);
  Hear("manager");
  EXPECT_FALSE(Hear("another", false));
  EXPECT_EQ(bond_.phase(), Phase::kFormed);
}

TEST_F(ABond, IsFormedAgainByAManagerThatWasRestarted) {
  bond_.Start(now_);
  Hear("manager");
  Until(now_ + Milliseconds(4000));
  EXPECT_TRUE(Hear("manager again"));
  EXPECT_EQ(bond_.phase(), Phase::kFormed);
}

TEST_F(ABond, TellsItsEndUntilTheOtherSideHasEndedToo) {
  bond_.Start(now_);
  Hear("manager");
  EXPECT_TRUE(bond_.Stop(now_));
  EXPECT_FALSE(bond_.active());
  EXPECT_EQ(Until(now_ + Milliseconds(250)), 2);
  EXPECT_FALSE(Hear("manager")) << "sent before it knew";
  Hear("manager", false);
  EXPECT_EQ(bond_.phase(), Phase::kOff);
  EXPECT_EQ(bond_.next(), std::nullopt);
}

TEST_F(ABond, DoesNotWaitForAnotherSideThatIsGone) {
  bond_.Start(now_);
  Hear("manager");
  bond_.Stop(now_);
  Until(now_ + Milliseconds(2000));
  EXPECT_EQ(bond_.phase(), Phase::kOff);
}

TEST_F(ABond, BeginsAgainWithTheNextActivation) {
  bond_.Start(now_);
  Hear("manager");
  bond_.Stop(now_);
  EXPECT_TRUE(bond_.Start(now_));
  EXPECT_EQ(bond_.phase(), Phase::kWaiting);
}

}  // namespace musher::bond_test
