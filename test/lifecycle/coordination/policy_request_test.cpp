// Requests to the policy, row by row of the manager's table.

#include "musher/test/lifecycle/coordination/one_controller.hpp"
#include "musher/test/lifecycle/coordination/policy.hpp"

namespace musher::testing::policy_request_test {

using ::testing::ElementsAre;
using ::testing::StartsWith;

class Requests : public Rules {};

TEST_F(Requests, WhileASwitchIsUnderWayAllAreRefused) {
  Robot();
  robot().On("a", "DeActive").takes = Milliseconds(90);
  robot().RequestSwitch("DeActive");
  const std::string busy = "111: switch 3 (to DeActive) is under way";
  for (const BuiltInState state : {kActive, kProtected, kLowPower, kOta, kTearDown}) {
    const RequestId request = Keep(state, 0);
    EXPECT_EQ(Text(robot().calls.at(request)), busy);
  }
  for (const auto what : {PolicyRequest::kWakeUp, PolicyRequest::kOta}) {
    EXPECT_EQ(Text(robot().calls.at(RequestPolicy(what))), busy);
  }
}

TEST_F(Requests, OtaIsLeftByItsOwnServiceOrByHandOnly) {
  Robot("OTA");
  for (const BuiltInState wanted : {kActive, kProtected, kLowPower, kTearDown}) {
    EXPECT_EQ(KeepAndWait(wanted, 0), "103: the machine is in OTA; leave OTA first");
  }
  EXPECT_EQ(KeepAndWait("OTA", 0), "ok");
  EXPECT_EQ(state(), "OTA");
  EXPECT_EQ(RequestAndWait(PolicyRequest::kOta, false), "ok");
  EXPECT_EQ(state(), "Active");
  robot().Set("OTA");
  const RequestId direct =
      robot().SendPolicyRequest({0, PolicyRequest::kSwitch, "Active", 0, false});
  EXPECT_EQ(AnswerTo(direct), "ok");
  EXPECT_EQ(state(), "Active");
}

TEST_F(Requests, OtaIsEnteredFromAnywhereAndOnce) {
  for (const BuiltInState from : {kActive, kProtected, kLowPower, kDeActive}) {
    Robot(from);
    EXPECT_EQ(RequestAndWait(PolicyRequest::kOta, true), "ok");
    EXPECT_EQ(state(), "OTA");
    EXPECT_EQ(RequestAndWait(PolicyRequest::kOta, true), "ok");
  }
}

TEST_F(Requests, OtaCannotBeLeftFromElsewhere) {
  Robot();
  EXPECT_EQ(RequestAndWait(PolicyRequest::kOta, false),
            "103: the machine is not in OTA, it is in Active");
}

TEST_F(Requests, LowPowerIsLeftForTheRequestedState) {
  for (const BuiltInState wanted : {kActive, kProtected, kOta}) {
    Robot("LowPower");
    EXPECT_EQ(KeepAndWait(wanted, 0), "ok");
    EXPECT_EQ(state(), wanted);
  }
  Robot("LowPower");
  robot().ClearLog();
  EXPECT_EQ(KeepAndWait("LowPower", 0), "ok");
  EXPECT_THAT(robot().log(), ElementsAre()) << "nothing to do";
}

TEST_F(Requests, FromElsewhereTheMachineIsSwitched) {
  for (const BuiltInState wanted : {kActive, kProtected, kLowPower, kOta}) {
    Robot("DeActive");
    EXPECT_EQ(KeepAndWait(wanted, 0), "ok");
    EXPECT_EQ(state(), wanted);
  }
  Robot();
  const RequestId request = Keep("TearDown", 60);
  robot().RunFor(std::chrono::seconds(20));
  EXPECT_EQ(Text(robot().calls.at(request)), "ok");
  EXPECT_TRUE(robot().stopped());
}

// The replaced code cannot command them.
TEST_F(Requests, DeActiveSelfCheckAndErrorCanBeCommanded) {
  Robot();
  for (const BuiltInState wanted : {kDeActive, kSelfCheck, kError}) {
    EXPECT_EQ(KeepAndWait(wanted, 0), "ok");
  }
  EXPECT_EQ(state(), "Error");
}

TEST_F(Requests, ADirectSwitchIsOneLikeAnyOther) {
  Robot();
  const auto direct = [this](const State& wanted) {
    return AnswerTo(robot().SendPolicyRequest({0, PolicyRequest::kSwitch, wanted, 0, false}));
  };
  EXPECT_EQ(direct("Protected"), "ok");
  EXPECT_THAT(direct("SetUp"), StartsWith("103: "));
  EXPECT_THAT(direct("Resting"), StartsWith("110: "));
  Battery(10);
  EXPECT_THAT(direct("Active"), StartsWith("113: the battery is at 10 %"));
}

TEST_F(Requests, WakeUpLeadsToActive) {
  Robot("LowPower");
  EXPECT_EQ(RequestAndWait(PolicyRequest::kWakeUp), "ok");
  EXPECT_EQ(state(), "Active");
}

TEST_F(Requests, WakeUpAtTenPercentLeadsToProtectedAndTheRestComesWithTheCharge) {
  Robot("LowPower");
  Battery(10);
  EXPECT_EQ(RequestAndWait(PolicyRequest::kWakeUp), "ok");
  EXPECT_EQ(state(), "Protected");
  Battery(40, true);
  EXPECT_EQ(state(), "Active");
}

TEST_F(Requests, WakeUpAtThreePercentIsRefusedWithWhatToDo) {
  Robot("LowPower");
  Battery(3);
  EXPECT_EQ(RequestAndWait(PolicyRequest::kWakeUp),
            "113: the battery is at 3 %: the machine is limited to LowPower until it is charged "
            "to 7 %");
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(Requests, WakeUpIsRefusedInOtherStates) {
  for (const BuiltInState from : {kActive, kProtected, kOta, kDeActive}) {
    Robot(from);
    EXPECT_EQ(RequestAndWait(PolicyRequest::kWakeUp),
              "103: the machine is not in LowPower, it is in " + std::string(from));
  }
}

TEST_F(Requests, WakeUpIsRefusedDuringAnEmergencyStop) {
  Robot("LowPower");
  robot().StopAll(7);
  EXPECT_THAT(RequestAndWait(PolicyRequest::kWakeUp), StartsWith("113: an emergency stop"));
}

TEST_F(Requests, AFailedWakeUpIsNotCalledASuccess) {
  Robot("LowPower");
  robot().On("a", "Active").code = 3009;
  EXPECT_THAT(RequestAndWait(PolicyRequest::kWakeUp), StartsWith("3009: a: failed"));
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(Requests, ARefusalIsRecordedWithItsRequest) {
  Robot();
  RequestAndWait(PolicyRequest::kWakeUp);
  EXPECT_THAT(
      Why(EventName::kPolicyRefused),
      Are(texts::PolicyRefused("wake-up", "the machine is not in LowPower, it is in Active"),
          texts::PolicyRequested("wake-up", {})));
}

TEST_F(Requests, WithoutAPolicyAllAreRefused) {
  Robot("Active", MachineOf(1));
  EXPECT_EQ(RequestAndWait(PolicyRequest::kWakeUp), "108: the config has no [policy]");
}

TEST_F(Requests, BeforeTheMachineBeginsAndAfterItsEndAllAreAnswered) {
  Harness t(WithPolicy());
  const RequestId before = t.SendPolicyRequest({0, PolicyRequest::kPowerOff, "", 0, false});
  EXPECT_EQ(Text(t.calls.at(before)), "104: the machine is not set up yet");
  t.Begin();
  t.Rest();
  t.Set("TearDown");
  t.Rest();
  const RequestId after = t.SendPolicyRequest({0, PolicyRequest::kPowerOff, "", 0, false});
  EXPECT_THAT(Text(t.calls.at(after)), StartsWith("103: the machine is torn down"));
}

TEST_F(Requests, AFencedControllerAnswersAnyway) {
  Robot("LowPower");
  const RequestId under_way = RequestPolicy(PolicyRequest::kWakeUp);
  robot().ReceiveRivalHeartbeat(100);
  EXPECT_THAT(Text(robot().calls.at(under_way)), StartsWith("106: "));
  EXPECT_THAT(RequestAndWait(PolicyRequest::kWakeUp), StartsWith("106: "));
}

TEST_F(Requests, BeforeTheStartAreRefusedAndLeaveNoRecord) {
  Harness t(WithPolicy());
  const RequestId request = t.SendPolicyRequest({0, PolicyRequest::kWakeUp, "", 0, false});
  EXPECT_EQ(Text(t.calls.at(request)), "104: the machine is not set up yet");
  EXPECT_THAT(t.records, ElementsAre());
}

// The stored level stayed in effect: there was no battery rule that would have lifted it.
class WithoutTheBatteryRule : public OneController {};

TEST_F(WithoutTheBatteryRule, AMachineThatTheRuleOfAnEarlierConfigTookDownWakesUp) {
  config_.policy.emplace();
  machine_ = MakeMachine(config_);
  event::Begin begin;
  begin.epoch = 1;
  begin.running = {false, false};
  begin.host = "here";
  begin.policy.lowering = BatteryFallback{"Active", "LowPower", 1};
  Do(begin);
  for (const ActuatorIndex i : {ActuatorIndex(0), ActuatorIndex(1)}) Come(i, "LowPower");
  ASSERT_EQ(machine_.state, "LowPower");
  Do(event::PolicyRequested{1, PolicyRequest::kWakeUp, "", 0, false});
  ObeyAll();
  EXPECT_EQ(machine_.state, "Active");
}

class RecordedRequests : public Rules {};

TEST_F(RecordedRequests, OfAKeepNameItsTimeAndWithoutTicksTheSwitch) {
  Robot();
  KeepAndWait("Protected", 0);
  EXPECT_TRUE(IsRecorded(texts::PolicyRequested("switch to Protected or end of the keep", {})));
  KeepAndWait("Active", 60);
  EXPECT_TRUE(IsRecorded(texts::PolicyRequested("keep in Active for 60 s", {})));
}

TEST_F(RecordedRequests, OfOtaTellItsEntryFromItsExit) {
  Robot();
  RequestAndWait(PolicyRequest::kOta, true);
  EXPECT_TRUE(IsRecorded(texts::PolicyRequested("OTA entry", {})));
  EXPECT_FALSE(IsRecorded(texts::PolicyRequested("OTA exit", {})));
  RequestAndWait(PolicyRequest::kOta, false);
  EXPECT_TRUE(IsRecorded(texts::PolicyRequested("OTA exit", {})));
}

// "Automatic LowPower when lying still: off" wakes the machine up.
class SwitchingLowPowerOff : public Rules {};

TEST_F(SwitchingLowPowerOff, IsAnsweredWhenTheMachineIsAwakeAndNotBefore) {
  Robot("LowPower");
  const RequestId off = RequestPolicy(PolicyRequest::kLowPowerSwitch, false);
  EXPECT_EQ(robot().calls.count(off), 0U);
  EXPECT_EQ(AnswerTo(off), "ok");
  EXPECT_EQ(state(), "Active");
}

TEST_F(SwitchingLowPowerOff, IsAnsweredThoughTheMachineCannotWakeUp) {
  Robot("LowPower");
  robot().StopAll(7);
  robot().RunFor(Milliseconds(10));
  EXPECT_EQ(RequestAndWait(PolicyRequest::kLowPowerSwitch, false), "ok");
  EXPECT_EQ(state(), "LowPower");
}

TEST_F(SwitchingLowPowerOff, IsRefusedWhileTheMachineGoesDownToLowPower) {
  Robot();
  RequestPolicy(PolicyRequest::kLowPowerSwitch, true);
  robot().On("a", "LowPower").takes = Milliseconds(90);
  robot().RequestSwitch("LowPower");
  const RequestId off = RequestPolicy(PolicyRequest::kLowPowerSwitch, false);
  ASSERT_EQ(robot().calls.count(off), 1U);
  EXPECT_EQ(Text(robot().calls.at(off)), "111: switch 3 (to LowPower) is under way");
  EXPECT_TRUE(policy().low_power) << "what is refused changes nothing";
}

}  // namespace musher::testing::policy_request_test
