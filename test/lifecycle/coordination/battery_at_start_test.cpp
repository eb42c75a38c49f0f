// A start with a battery that is, or was at last, too low for Active.

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "musher/test/lifecycle/coordination/policy.hpp"

namespace musher::testing::battery_at_start_test {

using ::testing::Contains;
using ::testing::Not;

class BatteryAtTheStart : public ::testing::Test {
 protected:
  // A robot that is being started, in SelfCheck.
  void Start(const MachineConfig& config = WithPolicy(), bool by_hand = false) {
    robot_ = std::make_unique<Harness>(config);
    robot_->disk().policy.level = stored_;
    robot_->disk_fails = disk_fails_;
    robot_->after_step = [this] { states_.push_back(robot_->machine().state); };
    robot_->Begin(by_hand);
    if (!by_hand) robot_->RunUntil([this] { return state() == "SelfCheck" || state() == "SetUp"; });
  }
  void Battery(int percent) {
    for (int i = 0; i < 4; ++i) {
      robot_->Feed(event::BatterySeen{percent, false, 0});
      robot_->RunFor(Milliseconds(500));
    }
  }
  const State& state() const { return robot_->machine().state; }

  BatteryLevel stored_ = BatteryLevel::kFree;
  std::string disk_fails_;
  std::unique_ptr<Harness> robot_;
  std::vector<State> states_;
};

TEST_F(BatteryAtTheStart, ThatIsTooLowForActiveEndsItInDeActiveAndThenAtItsCeiling) {
  Start();
  robot_->Feed(event::BatterySeen{15, false, 0});
  robot_->Rest();
  EXPECT_TRUE(robot_->usable());
  EXPECT_EQ(state(), "Protected");
  EXPECT_THAT(states_, Contains(State(kDeActive)));
  EXPECT_TRUE(IsRecorded(robot_->records,
                         texts::BatteryLimitsStart("the battery is at 15 %: the machine is limited "
                                                   "to Protected until it is charged to 22 %",
                                                   "DeActive")));
  EXPECT_THAT(states_, Not(Contains(State(kActive))));
  Battery(80);
  EXPECT_EQ(state(), "Active") << "the start is finished once it is charged";
}

TEST_F(BatteryAtTheStart, ThatIsAlmostEmptyEndsItInLowPower) {
  Start();
  robot_->Feed(event::BatterySeen{4, false, 0});
  robot_->Rest();
  EXPECT_EQ(state(), "LowPower");
  EXPECT_THAT(states_, Not(Contains(State(kActive))));
  Battery(15);
  EXPECT_EQ(state(), "Protected");
  Battery(80);
  EXPECT_EQ(state(), "Active");
}

// A robot that was charged while it was off, and one that was not: the start cannot tell.
TEST_F(BatteryAtTheStart, ThatWasLowAndSaysNothingYetEndsItInDeActive) {
  stored_ = BatteryLevel::kProtected;
  Start();
  robot_->Rest();
  EXPECT_EQ(state(), "DeActive");
  EXPECT_TRUE(IsRecorded(robot_->records, EventName::kBatteryLimitsStart));
  Battery(80);
  EXPECT_EQ(state(), "Active");
}

TEST_F(BatteryAtTheStart, ThatIsLowLeavesAMachineWithoutDeActiveInSelfCheck) {
  MachineConfig config = WithPolicy();
  std::erase(config.states, kDeActive);
  config.flow = DefaultFlow(config.states);
  ListAllStates(config);
  Start(config);
  robot_->Feed(event::BatterySeen{15, false, 0});
  robot_->Rest();
  EXPECT_EQ(state(), "SelfCheck");
  EXPECT_EQ(robot_->machine().phase, Phase::kFailed);
  EXPECT_THAT(robot_->start_up()->message,
              ::testing::HasSubstr("the machine is limited to Protected until it is charged to"));
}

TEST_F(BatteryAtTheStart, ThatIsLowRefusesActiveOfAPersonWhoStartsByHand) {
  Start(WithPolicy(), true);
  robot_->Rest();
  robot_->Feed(event::BatterySeen{15, false, 0});
  EXPECT_TRUE(robot_->Set("SelfCheck").done());
  EXPECT_EQ(robot_->Set("Active").reason,
            "the battery is at 15 %: the machine is limited to Protected until it is charged to "
            "22 %");
  EXPECT_TRUE(robot_->Set("DeActive").done());
}

TEST_F(BatteryAtTheStart, ThatIsLowBesideAFolderThatCannotBeWrittenRaisesNothingLater) {
  disk_fails_ = "the disk is full";
  Start();
  robot_->Feed(event::BatterySeen{15, false, 0});
  robot_->Rest();
  EXPECT_EQ(state(), "DeActive");
  Battery(80);
  EXPECT_EQ(state(), "DeActive") << "a person decides about a stop that is not on disk";
}

}  // namespace musher::testing::battery_at_start_test
