#include "musher/lifecycle/machine/under_way.hpp"

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::under_way_test {

class WhatIsUnderWay : public Switching {
 protected:
  static std::string In(const Harness& robot) {
    return UnderWay(robot.config(), robot.machine(), [&](ActuatorIndex i) {
      return robot.IsAlive(robot.config().actuators[i].name);
    });
  }
};

TEST_F(WhatIsUnderWay, IsNothingInAStableState) {
  Harness& t = Switching::In("Active", Ours(2));
  EXPECT_EQ(In(t), "");
}

TEST_F(WhatIsUnderWay, IsASwitchUntilItsEnd) {
  Harness& t = Switching::In("Active", Ours(2));
  t.RequestSwitch("LowPower");
  EXPECT_EQ(In(t), "a switch to LowPower is under way");
  t.Rest();
  EXPECT_EQ(In(t), "");
}

TEST_F(WhatIsUnderWay, IsTheRestartOfAnActuatorThatCrashed) {
  Harness& t = Switching::In("Active", Ours(2));
  t.Crash("a");
  ASSERT_TRUE(t.RunUntil([&] { return t.RecordOf("a").restart.at.has_value(); }));
  EXPECT_EQ(In(t), "a is to be restarted");
  t.Rest();
  EXPECT_EQ(In(t), "");
}

TEST_F(WhatIsUnderWay, IsTheTimeInWhichAnExitMayBecomeKnown) {
  Harness& t = Switching::In("Active", Ours(2));
  t.Feed(event::Vanished{0, t.RecordOf("a").report.incarnation, false, "connection lost"});
  ASSERT_TRUE(t.RecordOf("a").fault);
  EXPECT_EQ(In(t), "a may have exited");
  t.RunFor(Milliseconds(2100));
  EXPECT_EQ(In(t), "");
}

TEST_F(WhatIsUnderWay, IsTheCommandOfAnActuatorThatFollowsTheMachine) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "a").binds_to = {"b"};  // a is looked at before the one that is restarted
  Harness& t = Switching::In("Active", config);
  t.On("a", "DeActive").takes = Milliseconds(50);
  t.Crash("b");
  ASSERT_TRUE(t.RunUntil([&] { return t.RecordOf("a").command.has_value(); }));
  EXPECT_EQ(In(t), "a has a command to DeActive");
  t.Rest();
  EXPECT_EQ(In(t), "");
}

TEST_F(WhatIsUnderWay, IsTheStartAndTheTearDownOfTheMachine) {
  Harness robot(Ours(2));
  EXPECT_EQ(In(robot), "the machine is idle");
  robot.Begin();
  EXPECT_EQ(In(robot), "the machine is starting");
  robot.Rest();
  robot.RequestSwitch("TearDown");
  EXPECT_EQ(In(robot), "a switch to TearDown is under way");
  robot.Rest();
  EXPECT_EQ(robot.machine().phase, Phase::kStopped);
  EXPECT_EQ(In(robot), "");
}

}  // namespace musher::testing::under_way_test
