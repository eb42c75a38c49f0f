// What a standby goes on with: the last status of the controller that is gone.

#include "musher/controller/standby.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <string>

#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::testing::standby_test {

using ::testing::IsEmpty;
using ::testing::SizeIs;

class GoingOn : public ::testing::Test {
 protected:
  GoingOn() {
    for (ActuatorConfig& actuator : config_.actuators) actuator.command = {"run"};
    for (const ActuatorConfig& actuator : config_.actuators) {
      msg::ActuatorInfo info;
      info.name = actuator.name;
      info.state = "Active";
      info.presence = "present";
      info.health = "well";
      status_.actuators.push_back(info);
    }
  }

  msg::ActuatorInfo& Of(const std::string& name) {
    return *std::ranges::find(status_.actuators, name, &msg::ActuatorInfo::name);
  }
  std::vector<StoredActuator> Stored() const { return StoredActuatorsOf(config_, status_); }

  MachineConfig config_ = MachineOf(3);
  msg::MachineStatus status_;
};

TEST_F(GoingOn, WithARobotOfWhichAllIsUpKeepsNothingDown) {
  EXPECT_THAT(Stored(), IsEmpty());
}

TEST_F(GoingOn, LeavesDownWhatWasTornDownAloneOrHasEnded) {
  Of("a").state = "TearDown";
  Of("a").presence = "lost";
  Of("b").presence = "lost";
  const auto stored = Stored();
  ASSERT_THAT(stored, SizeIs(2));
  EXPECT_EQ(stored[0], (StoredActuator{"a", StaysDown::kTornDown, {}, {}}));
  EXPECT_EQ(stored[1], (StoredActuator{"b", StaysDown::kGivenUp, State("Active"), {}}));
}

TEST_F(GoingOn, KeepsWhatAPersonHolds) {
  Of("c").state = "LowPower";
  Of("c").held = true;
  EXPECT_EQ(Stored().at(0), (StoredActuator{"c", StaysDown::kNo, {}, State("LowPower")}));
}

// The host of the controller is gone with its actuators, and may come back.
TEST_F(GoingOn, LeavesNothingDownThatWasOutOfReachOrBeingRestarted) {
  Of("a").presence = "lost";
  Of("a").health = "partitioned";
  Of("b").presence = "lost";
  Of("b").restarting = true;
  EXPECT_THAT(Stored(), IsEmpty());
}

// It is down until a person starts it by hand: then it is not torn down.
TEST_F(GoingOn, DoesNotHoldDownWhatIsStartedByHand) {
  config_.actuators[*config_.IndexOf("a")].command.clear();
  Of("a").presence = "absent";
  EXPECT_EQ(Stored().at(0).stays_down, StaysDown::kNo);
}

}  // namespace musher::testing::standby_test
