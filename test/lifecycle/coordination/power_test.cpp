// Power-off and reboot: answered at once, TearDown two seconds later, the command at its end; after
// fifteen seconds regardless.

#include "musher/test/lifecycle/coordination/policy.hpp"

namespace musher::testing::power_test {

using std::chrono::seconds;
using ::testing::ElementsAre;

class Power : public Rules {
 protected:
  Duration After(Time begun) { return robot().power.at(0).first - begun; }
};

TEST_F(Power, OffIsAnsweredAtOnceThenTheMachineIsTornDownThenTheCommandComes) {
  Robot();
  const Time begun = robot().now();
  EXPECT_EQ(Text(robot().calls.at(RequestPolicy(PolicyRequest::kPowerOff))), "ok");
  robot().RunFor(Milliseconds(1999));
  EXPECT_EQ(state(), "Active");
  EXPECT_EQ(robot().machine().phase, Phase::kRunning);
  robot().RunFor(seconds(20));
  EXPECT_TRUE(robot().stopped());
  ASSERT_EQ(robot().power.size(), 1U);
  EXPECT_FALSE(robot().power[0].second);
  EXPECT_LT(After(begun), seconds(4));
  const RecordText given = texts::PowerCommandGiven(/*reboot=*/false, /*in_time=*/true, {});
  EXPECT_EQ(RecordWith(given).code, kCodeOk);
  EXPECT_THAT(Why(given),
              Are(given, EventName::kPowerOffStarted, texts::PolicyRequested("power-off", {})));
}

// It was forgotten, and the robot stayed in Active, or torn down with its power on.
TEST_F(Power, OffOutlastsTheControllerThatASupervisorRestarts) {
  for (const Duration crash : {Milliseconds(1000), Milliseconds(2050)}) {
    MachineConfig config = WithPolicy();
    Robot("Active", config);
    robot().On("a", "TearDown").takes = Milliseconds(90);
    robot().power.clear();
    RequestPolicy(PolicyRequest::kPowerOff);
    robot().RunFor(crash);
    robot().RestartController(false, true);
    robot().RunFor(seconds(20));
    EXPECT_TRUE(robot().stopped());
    ASSERT_EQ(robot().power.size(), 1U) << ToMilliseconds(crash);
    EXPECT_FALSE(robot().power[0].second);
    EXPECT_EQ(robot().disk().policy.power, PowerAhead::kNone);
  }
}

TEST_F(Power, OffIsEndedByAPersonsStartAndByABoot) {
  for (const bool boots : {false, true}) {
    Robot();
    robot().power.clear();
    RequestPolicy(PolicyRequest::kPowerOff);
    robot().RunFor(seconds(1));
    ASSERT_EQ(robot().disk().policy.power, PowerAhead::kOff);
    Harness next(WithPolicy());
    next.disk() = robot().disk();
    next.BeginController(false, boots, boots, boots);
    next.RunFor(seconds(30));
    EXPECT_TRUE(next.power.empty());
    EXPECT_EQ(next.disk().policy.power, PowerAhead::kNone);
  }
}

TEST_F(Power, ARebootIsTheSameWithTheOtherCommand) {
  MachineConfig config = WithPolicy();
  config.policy->power.reboot_command = {"reboot", "now"};
  Robot("Active", config);
  EXPECT_EQ(RequestAndWait(PolicyRequest::kReboot), "ok");
  robot().RunFor(seconds(20));
  ASSERT_EQ(robot().power.size(), 1U);
  EXPECT_TRUE(robot().power[0].second);
  EXPECT_TRUE(
      IsRecorded(texts::PowerCommandGiven(/*reboot=*/true, /*in_time=*/true, {"reboot", "now"})));
}

TEST_F(Power, AfterFifteenSecondsTheCommandComesRegardless) {
  MachineConfig config = WithPolicy();
  config.default_time = seconds(60);
  config.shutdown_budget = seconds(40);
  for (ActuatorConfig& actuator : config.actuators) actuator.times.back() = seconds(60);
  ActuatorNamed(config, "a").times.assign(config.states.size(), seconds(60));
  Robot("Active", config);
  robot().On("a", "TearDown").hangs = true;
  const Time begun = robot().now();
  RequestPolicy(PolicyRequest::kPowerOff);
  robot().RunFor(seconds(60));
  ASSERT_EQ(robot().power.size(), 1U);
  EXPECT_EQ(After(begun), seconds(15));
  EXPECT_EQ(RecordWith(texts::PowerCommandGiven(/*reboot=*/false, /*in_time=*/false, {})).code,
            kCodeTimeout);
}

TEST_F(Power, ASwitchUnderWayEndsFirstButNotForEver) {
  MachineConfig config = WithPolicy();
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.times.assign(config.states.size(), seconds(60));
  }
  Robot("Active", config);
  robot().On("a", "LowPower").takes = seconds(5);
  const RequestId request = robot().RequestSwitch("LowPower");
  RequestPolicy(PolicyRequest::kPowerOff);
  robot().RunFor(seconds(20));
  EXPECT_TRUE(robot().answers.at(request).done());
  EXPECT_THAT(states(), ElementsAre("Active", "LowPower", "TearDown"));
  EXPECT_TRUE(robot().stopped());
}

TEST_F(Power, InOtaItIsRefused) {
  Robot("OTA");
  for (const auto what : {PolicyRequest::kPowerOff, PolicyRequest::kReboot}) {
    EXPECT_EQ(RequestAndWait(what), "103: the machine is in OTA; leave OTA first");
  }
}

TEST_F(Power, RequestedTwiceItIsOnePowerOff) {
  Robot();
  EXPECT_EQ(Text(robot().calls.at(RequestPolicy(PolicyRequest::kPowerOff))), "ok");
  EXPECT_EQ(Text(robot().calls.at(RequestPolicy(PolicyRequest::kPowerOff))), "ok");
  EXPECT_EQ(Text(robot().calls.at(RequestPolicy(PolicyRequest::kReboot))),
            "111: the robot is about to be powered off");
  robot().RunFor(seconds(30));
  EXPECT_EQ(robot().power.size(), 1U);
}

// A command may fail; the robot still runs then.
TEST_F(Power, RequestedAgainAfterItsCommandTheCommandIsGivenAgainAlsoTheOther) {
  MachineConfig config = WithPolicy();
  config.default_time = seconds(60);
  config.shutdown_budget = seconds(40);
  for (ActuatorConfig& actuator : config.actuators) actuator.times.back() = seconds(60);
  ActuatorNamed(config, "a").times.assign(config.states.size(), seconds(60));
  Robot("Active", config);
  robot().On("a", "LowPower").hangs = true;
  robot().RequestSwitch("LowPower");
  RequestPolicy(PolicyRequest::kPowerOff);
  robot().RunFor(seconds(16));
  ASSERT_EQ(robot().power.size(), 1U);
  EXPECT_EQ(Text(robot().calls.at(RequestPolicy(PolicyRequest::kPowerOff))), "ok");
  EXPECT_EQ(Text(robot().calls.at(RequestPolicy(PolicyRequest::kReboot))), "ok");
  ASSERT_EQ(robot().power.size(), 3U);
  EXPECT_FALSE(robot().power[1].second);
  EXPECT_TRUE(robot().power[2].second);
}

TEST_F(Power, MeanwhileNothingGoesUp) {
  Robot("Protected");
  RequestPolicy(PolicyRequest::kPowerOff);
  const SwitchResult up = robot().Set("Active");
  EXPECT_EQ(up.code, kCodeProtectedError);
  EXPECT_EQ(up.reason, "the robot is about to be powered off");
  EXPECT_TRUE(robot().Set("Protected").done());
}

TEST_F(Power, AnEmergencyStopDoesNotKeepTheRobotOn) {
  Robot();
  robot().StopAll(7);
  RequestPolicy(PolicyRequest::kPowerOff);
  robot().RunFor(seconds(20));
  EXPECT_EQ(robot().power.size(), 1U);
}

// Found by a scenario: the rule against switches up took TearDown for a switch up.
TEST_F(Power, OffDuringTheStartTearsTheMachineDown) {
  Harness t(WithPolicy());
  t.Begin();
  t.SendPolicyRequest({0, PolicyRequest::kPowerOff, "", 0, false});
  t.On("a", "SelfCheck").hangs = true;
  t.RunFor(seconds(20));
  EXPECT_TRUE(t.stopped());
  EXPECT_EQ(t.machine().state, "TearDown");
  ASSERT_EQ(t.power.size(), 1U);
}

TEST_F(Power, AMachineWithoutTearDownIsSwitchedOffWhenTheTimeIsOver) {
  MachineConfig config = WithPolicy();
  std::erase(config.states, "TearDown");
  Robot("Active", config);
  const Time begun = robot().now();
  RequestPolicy(PolicyRequest::kPowerOff);
  robot().RunFor(seconds(60));
  ASSERT_EQ(robot().power.size(), 1U);
  EXPECT_EQ(After(begun), seconds(15));
}

TEST_F(Power, APlainTearDownIsNotAPowerOff) {
  Robot();
  robot().Set("TearDown");
  robot().RunFor(seconds(30));
  EXPECT_TRUE(robot().power.empty());
}

TEST_F(Power, OffByAnEmptyBatteryWaitsOnlyWhereTheManagerAnnouncesItFirst) {
  for (const bool announced : {false, true}) {
    MachineConfig config = WithPolicy();
    config.policy->battery->tear_down_after = Duration::zero();
    if (announced) config.policy->empty_battery_delay = config.policy->power.delay;
    Robot("Active", config);
    EXPECT_TRUE(robot().Set("LowPower").done());
    for (int i = 0; i < kConfirmingSamples; ++i) robot().Feed(event::BatterySeen{0, false});
    EXPECT_EQ(robot().machine().phase, announced ? Phase::kRunning : Phase::kStopping);
    robot().RunFor(config.policy->power.delay);
    EXPECT_NE(robot().machine().phase, Phase::kRunning);
  }
}

}  // namespace musher::testing::power_test
