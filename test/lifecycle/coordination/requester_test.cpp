// Who has requested a switch of the machine, and what a manager of ROS 2 may not undo: nav2's
// bonded manager brought a machine that a person had paused back to Active after a second.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/policy.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::requester_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

const Requester kAlice{"alice@dog1", false};
const Requester kManager{"/lifecycle_manager", true};

class Requesters : public Switching {
 protected:
  static SwitchResult Activate(Harness& t, const Requester& by) {
    return t.Set("Active", std::nullopt, by);
  }
};

TEST_F(Requesters, AManagerDoesNotEndWhatAPersonHasPaused) {
  Harness& t = In("Active");
  ASSERT_TRUE(t.Set("DeActive", std::nullopt, kAlice).done());
  const SwitchResult refused = Activate(t, kManager);
  EXPECT_EQ(refused.outcome, SwitchOutcome::kRefused);
  EXPECT_THAT(refused.reason, AllOf(HasSubstr("DeActive was last requested by alice@dog1 (switch "),
                                    HasSubstr("run `musher set Active`")));
  EXPECT_EQ(t.machine().state, "DeActive");
}

TEST_F(Requesters, AManagerEndsItsOwnPause) {
  Harness& t = In("Active");
  ASSERT_TRUE(t.Set("DeActive", std::nullopt, kManager).done());
  EXPECT_TRUE(Activate(t, kManager).done());
}

TEST_F(Requesters, APersonsPauseLastsAlsoIfAManagerPausesFurther) {
  Harness& t = In("Active");
  ASSERT_TRUE(t.Set("DeActive", std::nullopt, kAlice).done());
  ASSERT_TRUE(t.Set("LowPower", std::nullopt, kManager).done());
  EXPECT_FALSE(Activate(t, kManager).done());
  EXPECT_TRUE(t.Set("DeActive", std::nullopt, kManager).done()) << "what the person has requested";
}

TEST_F(Requesters, APersonWhoRequestsWhatAManagerIsDoingHasRequestedIt) {
  Harness& t = In("Active");
  t.RequestSwitch("DeActive", std::nullopt, kManager);
  ASSERT_TRUE(t.Set("DeActive", std::nullopt, kAlice).done());
  EXPECT_FALSE(Activate(t, kManager).done());
  EXPECT_EQ(t.machine().requested_by, "alice@dog1");
}

TEST_F(Requesters, APersonEndsAPersonsPauseAndThenAManagerMayPauseAndResume) {
  Harness& t = In("Active");
  ASSERT_TRUE(t.Set("DeActive", std::nullopt, kAlice).done());
  ASSERT_TRUE(Activate(t, kAlice).done());
  ASSERT_TRUE(t.Set("DeActive", std::nullopt, kManager).done());
  EXPECT_TRUE(Activate(t, kManager).done());
}

TEST_F(Requesters, AManagerDoesNotEndTheFallbackAfterALoss) {
  Harness& t = In("Active", OursWithCriticalB());
  t.On("b", "exec").exit_code = 2;
  t.Crash("b");
  t.Rest();
  ASSERT_EQ(t.machine().state, "Protected");
  EXPECT_EQ(t.machine().requested_by, "the loss of a critical actuator");
  const SwitchResult refused = Activate(t, kManager);
  EXPECT_EQ(refused.outcome, SwitchOutcome::kRefused);
}

TEST_F(Requesters, AManagerDoesNotRequestAgainWhatAnEmergencyStopHasUndone) {
  Harness& t = In("DeActive");
  t.RestartController();  // no request for DeActive has reached this controller
  t.Rest();
  ASSERT_TRUE(t.Set("DeActive", std::nullopt, kAlice).done());
  ASSERT_TRUE(Activate(t, kAlice).done());
  ASSERT_TRUE(t.Set("DeActive", std::nullopt, kManager).done());
  for (const char* name : {"a", "b", "c"}) t.On(name, "Active").takes = Milliseconds(80);
  const RequestId request = t.RequestSwitch("Active", std::nullopt, kManager);
  t.RunFor(Milliseconds(20));
  t.StopAll(7, "bob");
  ASSERT_TRUE(t.RunUntil([&] { return t.answers.count(request) > 0; }));
  ASSERT_EQ(t.answers.at(request).outcome, SwitchOutcome::kUndone);
  ASSERT_TRUE(t.Released());
  const SwitchResult refused = Activate(t, kManager);
  EXPECT_THAT(refused.reason, HasSubstr("the emergency stop of bob"));
  EXPECT_TRUE(Activate(t, kAlice).done());
}

TEST_F(Requesters, WhatAnEarlierControllerLeftIsNotSwitchedUpByAManager) {
  Harness& t = In("Active");
  ASSERT_TRUE(t.Set("DeActive", std::nullopt, kAlice).done());
  t.RestartController();
  t.Rest();
  ASSERT_EQ(t.machine().state, "DeActive");
  const SwitchResult refused = Activate(t, kManager);
  EXPECT_THAT(refused.reason, HasSubstr("DeActive was last requested by an earlier controller"));
}

TEST_F(Requesters, ARestartedControllerOfAnActiveMachineLetsItsManagerPauseAndResume) {
  Harness& t = In("Active");
  t.RestartController();
  t.Rest();
  ASSERT_TRUE(t.Set("DeActive", std::nullopt, kManager).done());
  EXPECT_TRUE(Activate(t, kManager).done());
}

TEST_F(Requesters, ASwitchOfOneActuatorSaysNothingAboutTheMachine) {
  Harness& t = In("Active");
  ASSERT_TRUE(t.Set("DeActive", "a", kAlice).done());
  EXPECT_TRUE(t.Set("DeActive", std::nullopt, kManager).done());
  EXPECT_TRUE(Activate(t, kManager).done());
}

TEST_F(Requesters, AreInTheRecordAndOfTheMachine) {
  Harness& t = In("Active");
  EXPECT_EQ(t.machine().requested_by, "") << "it has started by itself";
  ASSERT_TRUE(t.Set("LowPower", std::nullopt, kAlice).done());
  EXPECT_EQ(t.machine().requested_by, "alice@dog1");
  EXPECT_THAT(t.records,
              ::testing::Contains(::testing::Field(&action::Record::message,
                                                   "switch to LowPower requested by alice@dog1")));
}

// The policy, and what asks it.
class RequestersOfThePolicy : public Rules {
 protected:
  const std::string& requested_by() { return robot().machine().requested_by; }
  // The request of alice, and two seconds.
  void Request(PolicyRequest what, const State& wanted = {}, std::int64_t seconds = 0,
               bool enable = false) {
    robot().SendPolicyRequest({0, what, wanted, seconds, enable, "alice@dog1"});
    robot().RunFor(std::chrono::seconds(2));
  }
};

TEST_F(RequestersOfThePolicy, ItsOwnSwitchIsNamedAndNoManagerUndoesIt) {
  Robot();
  Battery(15);
  ASSERT_EQ(state(), "Protected");
  EXPECT_EQ(requested_by(), "the policy");
  const SwitchResult refused = robot().Set("Active", std::nullopt, kManager);
  EXPECT_EQ(refused.outcome, SwitchOutcome::kRefused);
  EXPECT_THAT(refused.reason, HasSubstr("Protected was last requested by the policy (switch "));
}

TEST_F(RequestersOfThePolicy, ARequestIsNamedByItsClientInTheRecordAndOfTheMachine) {
  Robot("LowPower");
  Request(PolicyRequest::kWakeUp);
  EXPECT_EQ(state(), "Active");
  EXPECT_EQ(requested_by(), "alice@dog1");
  EXPECT_TRUE(IsRecorded(texts::PolicyRequested("wake-up", {}, "alice@dog1")));
  Request(PolicyRequest::kOta, {}, 0, true);
  EXPECT_EQ(state(), "OTA");
  EXPECT_EQ(requested_by(), "alice@dog1");
}

TEST_F(RequestersOfThePolicy, AManagerDoesNotEndWhatAPersonHasRequestedByIt) {
  Robot();
  ASSERT_TRUE(robot().Set("Active", std::nullopt, kManager).done());
  Request(PolicyRequest::kKeep, "Protected", 1);
  ASSERT_EQ(state(), "Protected");
  EXPECT_EQ(requested_by(), "alice@dog1");
  robot().RunFor(std::chrono::seconds(2));
  const SwitchResult refused = robot().Set("Active", std::nullopt, kManager);
  EXPECT_THAT(refused.reason, HasSubstr("Protected was last requested by alice@dog1 (switch "));
}

TEST_F(RequestersOfThePolicy, ASwitchByItAndWithoutANameAreWhatTheyAre) {
  Robot();
  Request(PolicyRequest::kSwitch, "DeActive");
  EXPECT_EQ(requested_by(), "alice@dog1");
  robot().SendPolicyRequest({0, PolicyRequest::kSwitch, "Active", 0, false});
  robot().RunFor(std::chrono::seconds(2));
  EXPECT_EQ(requested_by(), "a request to the policy");
}

TEST_F(RequestersOfThePolicy, ThePowerOffIsOfItsClientAlsoWhenItsTimeHasCome) {
  Robot();
  Request(PolicyRequest::kPowerOff);
  robot().RunFor(std::chrono::seconds(20));
  ASSERT_TRUE(robot().stopped());
  EXPECT_EQ(requested_by(), "alice@dog1");
}

TEST_F(RequestersOfThePolicy, ThePowerOffOfAnEmptyBatteryIsOfThePolicy) {
  Robot();
  Battery(0);
  robot().RunFor(std::chrono::seconds(60));
  ASSERT_TRUE(robot().stopped());
  EXPECT_EQ(requested_by(), "the policy");
}

}  // namespace musher::testing::requester_test
