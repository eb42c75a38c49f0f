// A switch is requested while a late actuator is being driven to the state of the machine on its
// own. Such a request was refused with TargetBusy, right after `musher up --detach`.

#include <gmock/gmock.h>

#include "musher/base/code.hpp"
#include "musher/lifecycle/switch/plan.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::waiting_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class WaitingSwitches : public Switching {
 protected:
  // The machine is in `state`; c was restarted and is being driven there, 80 of its 100 ms are
  // left.
  Harness& WithALateOne(const State& state, MachineConfig config = MachineOf(3)) {
    Harness& t = In(state, std::move(config));
    t.On("c", state).takes = Milliseconds(80);
    StartLate(t, "c", state);
    return t;
  }
  static void StartLate(Harness& t, const std::string& name, const State& state) {
    t.Crash(name);
    t.RunFor(Milliseconds(1));
    t.StartActuator(name);
    ASSERT_TRUE(t.RunUntil([&] {
      const auto& command = t.RecordOf(name).command;
      return command && command->target == state;
    }));
    t.ClearLog();
  }
  static bool Answered(const Harness& t, RequestId request) { return t.answers.count(request) > 0; }
};

TEST_F(WaitingSwitches, UpBeginsOnceTheLateActuatorIsFreeAndIncludesIt) {
  Harness& t = WithALateOne("LowPower");
  const SwitchResult result = t.Set("Active");
  EXPECT_TRUE(result.done()) << result.reason;
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(t.StateOf(name), "Active");
}

TEST_F(WaitingSwitches, NothingIsSentBeforeTheLateActuatorIsFree) {
  Harness& t = WithALateOne("LowPower");
  const RequestId request = t.RequestSwitch("Active");
  EXPECT_FALSE(Answered(t, request));
  EXPECT_THAT(t.log(), ElementsAre());
  EXPECT_FALSE(t.machine().current);
}

TEST_F(WaitingSwitches, TheSameRequestJoinsTheWaitingOne) {
  Harness& t = WithALateOne("LowPower");
  const RequestId first = t.RequestSwitch("Active");
  const RequestId again = t.RequestSwitch("Active");
  t.Rest();
  EXPECT_TRUE(t.answers.at(first).done());
  EXPECT_EQ(t.answers.at(again).number, t.answers.at(first).number);
}

TEST_F(WaitingSwitches, AnotherRequestIsRefusedWithARetryTime) {
  Harness& t = WithALateOne("LowPower");
  const RequestId first = t.RequestSwitch("Active");
  const SwitchResult other = t.Set("DeActive");
  EXPECT_EQ(other.outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(other.code, kCodeTargetBusy);
  EXPECT_THAT(other.reason, AllOf(HasSubstr("switch to Active is waiting"), HasSubstr("retry in")));
  t.Rest();
  EXPECT_TRUE(t.answers.at(first).done());
}

TEST_F(WaitingSwitches, AMoreUrgentRequestBeginsInstead) {
  for (const BuiltInState urgent : {kError, kTearDown}) {
    Harness& t = WithALateOne("LowPower");
    const RequestId request = t.RequestSwitch("Active");
    EXPECT_EQ(t.Set(urgent).outcome, SwitchOutcome::kDone);
    ASSERT_TRUE(Answered(t, request));
    EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kRefused);
    EXPECT_EQ(t.answers.at(request).code, kCodeTargetBusy);
    EXPECT_THAT(t.answers.at(request).reason, HasSubstr(std::string("(to ") + State(urgent) + ")"));
  }
}

// Its deadline passed while the TearDown waited for another actuator, and nothing ended it.
TEST_F(WaitingSwitches, ATearDownThatWaitsItselfRefusesTheWaitingSwitchAtOnce) {
  MachineConfig config = Ours(3);
  ActuatorNamed(config, "b").stage = 2;
  ActuatorNamed(config, "c").stage = 3;
  Harness t(config);
  t.On("b", "SelfCheck").takes = Milliseconds(80);
  t.disk().remote = {{"c", "another host"}};  // where an earlier controller has left it
  t.Begin();
  ASSERT_TRUE(t.RunUntil(
      [&] { return t.machine().phase == Phase::kRunning && t.RecordOf("b").command.has_value(); }));
  const RequestId waiting = t.RequestSwitch("OTA", "b");
  ASSERT_FALSE(Answered(t, waiting));
  t.RequestSwitch("TearDown");
  ASSERT_TRUE(t.machine().stopping);
  ASSERT_TRUE(t.machine().stopping->announced_by) << "it waits for c";
  ASSERT_TRUE(Answered(t, waiting));
  EXPECT_EQ(t.answers.at(waiting).outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(t.answers.at(waiting).code, kCodeStateInvalid);
  EXPECT_GT(NextDeadline(t.config(), t.machine()), t.now());
}

TEST_F(WaitingSwitches, ASwitchThatWaitsForAHungActuatorIsRefusedWithinItsTime) {
  Harness& t = WithALateOne("LowPower");
  t.On("c", "LowPower").hangs = true;
  StartLate(t, "c", "LowPower");
  const Time begun = t.now();
  const SwitchResult result = t.Set("Active");
  EXPECT_EQ(result.outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(result.code, kCodeTargetBusy);
  EXPECT_LE(t.now() - begun, Milliseconds(100 + 3 * 300 + 100));
}

TEST_F(WaitingSwitches, ASwitchThatWaitsForAnActuatorThatCrashesContinuesWithoutIt) {
  Harness& t = WithALateOne("LowPower");
  const RequestId request = t.RequestSwitch("Active");
  t.Crash("c");
  t.Rest();
  ASSERT_TRUE(Answered(t, request));
  EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(t.answers.at(request).degraded, ElementsAre("c"));
  EXPECT_EQ(t.StateOf("a"), "Active");
}

TEST_F(WaitingSwitches, AnEmergencyStopRefusesTheWaitingSwitchAtOnce) {
  Harness& t = WithALateOne("LowPower");
  const RequestId request = t.RequestSwitch("Active");
  t.StopAll(7);
  t.RunFor(Milliseconds(10));
  ASSERT_TRUE(Answered(t, request));
  EXPECT_EQ(t.answers.at(request).code, kCodeProtectedError);
}

TEST_F(WaitingSwitches, AFencedControllerAnswersTheWaitingRequest) {
  Harness& t = WithALateOne("LowPower");
  const RequestId request = t.RequestSwitch("Active");
  t.ReceiveRivalHeartbeat(9);
  ASSERT_TRUE(Answered(t, request));
  EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(t.answers.at(request).code, kCodePermissionDenied);
}

TEST_F(WaitingSwitches, OfTheLateActuatorItselfWaitsToo) {
  Harness& t = WithALateOne("Active");
  const SwitchResult result = t.Set("LowPower", "c");
  EXPECT_TRUE(result.done()) << result.reason;
  EXPECT_EQ(t.StateOf("c"), "LowPower");
  EXPECT_TRUE(t.RecordOf("c").held);
}

TEST_F(WaitingSwitches, NoOtherLateActuatorIsDrivenBeforeTheWaitingSwitch) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "b").after = {"c"};  // it goes up after c
  Harness& t = WithALateOne("LowPower", config);
  t.On("b", "LowPower").takes = Milliseconds(80);
  t.Crash("b");
  t.RunFor(Milliseconds(1));
  t.StartActuator("b");
  t.RunFor(Milliseconds(30));
  const RequestId request = t.RequestSwitch("Active");
  t.Rest();
  ASSERT_TRUE(Answered(t, request));
  EXPECT_NE(t.answers.at(request).outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(t.StateOf("b"), "Active");
}

TEST_F(WaitingSwitches, ThePlanReportsThatItWouldWaitAndForWhat) {
  Harness& t = WithALateOne("LowPower");
  const Plan plan = MakePlan(t.config(), t.machine(), State("Active"));
  ASSERT_TRUE(plan.free_by);
  EXPECT_GT(*plan.free_by, t.now());
  EXPECT_EQ(plan.refusal->message, "c is still busy with LowPower");
  EXPECT_EQ(plan.steps[2].wave, 1) << "it shows what is done after that";
}

TEST_F(WaitingSwitches, AnotherReasonAgainstASwitchRefusesItAtOnce) {
  MachineConfig config = MachineOf(3);
  std::erase(ActuatorNamed(config, "b").states, "DeActive");
  ActuatorNamed(config, "b").times.pop_back();
  Harness& t = WithALateOne("LowPower", config);
  const SwitchResult result = t.Set("DeActive");
  EXPECT_EQ(result.code, kCodeUnSupport) << result.reason;
}

TEST_F(WaitingSwitches, OfOneActuatorIsRefusedWithTheStateOfThatActuator) {
  Harness& t = WithALateOne("Active");
  const RequestId request = t.RequestSwitch("LowPower", "c");
  t.RequestSwitch("Error");
  ASSERT_TRUE(Answered(t, request));
  EXPECT_EQ(t.answers.at(request).state, "SelfCheck");
}

TEST_F(WaitingSwitches, AWaitIsRecordedAndIsNoError) {
  Harness& t = WithALateOne("LowPower");
  t.RequestSwitch("Active");
  const action::Record& record = t.whole_records.back();
  EXPECT_THAT(record, Is(EventName::kSwitchWaiting));
  EXPECT_EQ(record.code, kCodeOk);
}

}  // namespace musher::testing::waiting_test
