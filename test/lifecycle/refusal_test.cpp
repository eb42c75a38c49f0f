// Each refusal of the decision code, provoked. Those of a shell, of a link to an actuator and of
// the start of a controller are in their tests.

#include "musher/lifecycle/refusal.hpp"

#include <gmock/gmock.h>

#include "musher/lifecycle/actuator/capability.hpp"
#include "musher/lifecycle/ros2/managed_node.hpp"
#include "musher/lifecycle/switch/plan.hpp"
#include "musher/test/lifecycle/coordination/policy.hpp"
#include "musher/test/lifecycle/one_actuator.hpp"
#include "musher/test/support/refusals.hpp"

namespace musher::testing::refusal_test {

using ::testing::Optional;

TEST(ARefusal, HasItsCodeAndTheValuesInTheirPlaces) {
  const Error refusal = Refused<Refusal::kMachineSwitching>(CommandNumber(7), State("LowPower"));
  EXPECT_EQ(refusal, (Error{kCodeTargetBusy, "switch 7 to LowPower is under way"}));
  EXPECT_THAT(refusal, IsRefused(Refusal::kMachineSwitching));
  EXPECT_FALSE(HasSentence("switch 7 to LowPower is over", Refusal::kMachineSwitching, true));
  EXPECT_THAT("a: switch 7 to LowPower is under way; b", HasRefusal(Refusal::kMachineSwitching));
}

// A machine in DeActive whose actuators a, b, c are present, checked and well.
class RefusedPlans : public ::testing::Test {
 protected:
  RefusedPlans() {
    machine_ = MakeMachine(config_);
    machine_.phase = Phase::kRunning;
    machine_.start_up.set_up = true;
    machine_.host = "here";
    PutAllIn("DeActive");
    for (KnownActuator& known : machine_.actuators) {
      known.presence = Presence::kPresent;
      known.checked = true;
    }
  }

  void PutAllIn(const State& state) {
    machine_.state = state;
    for (KnownActuator& known : machine_.actuators) known.report.state = state;
  }
  std::optional<Error> To(const State& target) const {
    return MakePlan(config_, machine_, target).refusal;
  }
  std::optional<Error> OfB(const State& target) const {
    return MakePlan(config_, machine_, target, ActuatorIndex(1)).refusal;
  }
  // The answer to an event that is a request of its own.
  std::optional<Error> AnswerTo(const Event& event) {
    for (const Action& action : Step(config_, machine_, event, Time(std::chrono::hours(1)))) {
      const auto* answer = std::get_if<action::AnswerCall>(&action);
      if (answer != nullptr && !answer->result) return answer->result.error();
    }
    return std::nullopt;
  }

  MachineConfig config_ = MachineOf(3);
  Machine machine_;
  ActuatorConfig& b_ = config_.actuators[1];
  KnownActuator& RecordOfB() { return machine_.actuators[1]; }
};

TEST_F(RefusedPlans, OfAMachineThatCannotBeSwitchedAtAll) {
  EXPECT_THAT(To(State("Lowpower")), Optional(IsRefused(Refusal::kUnknownState)));
  machine_.start_up.set_up = false;
  EXPECT_THAT(To("Active"), Optional(IsRefused(Refusal::kNotSetUp)));
  machine_.start_up.set_up = true;
  machine_.phase = Phase::kFenced;
  EXPECT_THAT(To("Active"), Optional(IsRefused(Refusal::kLedByAnother)));
  machine_.phase = Phase::kStopped;
  EXPECT_THAT(To("Active"), Optional(IsRefused(Refusal::kMachineTornDown)));
}

TEST_F(RefusedPlans, OutsideOfTheFlow) {
  EXPECT_THAT(To("SetUp"), Optional(IsRefused(Refusal::kNoTransition)));
  RecordOfB().report.state = kTearDown;
  EXPECT_THAT(OfB("Active"), Optional(IsRefused(Refusal::kFinalState)));
}

TEST_F(RefusedPlans, DuringAnEmergencyStop) {
  machine_.emergency.stop = EmergencyStop{7, "alice", "smoke"};
  EXPECT_THAT(To("Active"), Optional(IsRefused(Refusal::kStopForbidsUp)));
  EXPECT_THAT(To("Active")->message, ::testing::HasSubstr("by alice (smoke); until"));
  PutAllIn("Active");
  EXPECT_THAT(To("Active"), Optional(IsRefused(Refusal::kStopHoldsMachine)));
}

TEST_F(RefusedPlans, ByThePolicy) {
  config_.policy.emplace().battery.emplace();
  machine_.policy.loaded = true;
  machine_.policy.level = BatteryLevel::kProtected;
  EXPECT_THAT(To("Active"), Optional(IsRefused(Refusal::kAboveCeiling)));
  machine_.policy.power.emplace();
  EXPECT_THAT(To("Active"), Optional(IsRefused(Refusal::kPowerOffAhead)));
  machine_.policy.power->reboot = true;
  EXPECT_THAT(To("Active"), Optional(IsRefused(Refusal::kRebootAhead)));
}

TEST_F(RefusedPlans, OfAnActuatorThatIsNotThere) {
  RecordOfB().presence = Presence::kAbsent;
  EXPECT_THAT(OfB("LowPower"), Optional(IsRefused(Refusal::kActuatorAbsent)));
  RecordOfB().presence = Presence::kStarting;
  EXPECT_THAT(OfB("LowPower"), Optional(IsRefused(Refusal::kActuatorStarting)));
  RecordOfB().presence = Presence::kLost;
  EXPECT_THAT(OfB("LowPower"), Optional(IsRefused(Refusal::kActuatorLost)));
}

TEST_F(RefusedPlans, OfAnActuatorThatDoesNotListTheState) {
  std::erase(b_.states, "Active");
  EXPECT_THAT(OfB("Active"), Optional(IsRefused(Refusal::kStateUnsupported)));
  EXPECT_THAT(To("Active"), Optional(IsRefused(Refusal::kStateMissing)));
}

TEST_F(RefusedPlans, OfAnActuatorThatIsBusyOrRestarts) {
  RecordOfB().report.target = "LowPower";
  EXPECT_THAT(OfB("OTA"), Optional(IsRefused(Refusal::kActuatorBusy)));
  EXPECT_THAT(To("Active"), Optional(IsRefused(Refusal::kActuatorStillBusy)));
  RecordOfB().restart.requested = true;
  EXPECT_THAT(OfB("OTA"), Optional(IsRefused(Refusal::kActuatorRestarting)));
}

TEST_F(RefusedPlans, OfAnActuatorThatMayNotGoUp) {
  EXPECT_THAT(OfB("Active"), Optional(IsRefused(Refusal::kMoreActiveThanMachine)));
  RecordOfB().report.state = "LowPower";
  RecordOfB().suspended = true;
  EXPECT_THAT(OfB("DeActive"), Optional(IsRefused(Refusal::kSuspended)));
  RecordOfB().checked = false;
  EXPECT_THAT(OfB("DeActive"), Optional(IsRefused(Refusal::kUnchecked)));
}

TEST_F(RefusedPlans, UpWithoutACriticalActuator) {
  b_.critical = true;
  RecordOfB().checked = false;
  EXPECT_THAT(To("Active"), Optional(IsRefused(Refusal::kCriticalUnchecked)));
  RecordOfB().report.state = kTearDown;
  EXPECT_THAT(To("Active"), Optional(IsRefused(Refusal::kCriticalTornDown)));
  RecordOfB().presence = Presence::kLost;
  EXPECT_THAT(To("Active"), Optional(IsRefused(Refusal::kCriticalUnavailable)));
}

TEST_F(RefusedPlans, UpWithACriticalModuleThatHasNotAnsweredAndCannotBeQueried) {
  b_.critical = true;
  b_.protocol = Protocol::kCyberdog;
  RecordOfB().report.target = "OTA";
  RecordOfB().fault = ActuatorFault{kCodeTimeout, "overdue"};
  EXPECT_THAT(To("Active"), Optional(IsRefused(Refusal::kCriticalSilent)));
}

TEST_F(RefusedPlans, OfARestartThatTheControllerCannotDo) {
  const event::RestartRequested restart{7, "b"};
  EXPECT_THAT(AnswerTo(event::RestartRequested{7, "tail"}),
              Optional(IsRefused(Refusal::kUnknownActuator)));
  EXPECT_THAT(AnswerTo(restart), Optional(IsRefused(Refusal::kNoCommand)));
  b_.command = {"b"};
  RecordOfB().report.incarnation = 5;
  RecordOfB().report.host = "here";
  EXPECT_THAT(AnswerTo(restart), Optional(IsRefused(Refusal::kProcessUnknown)));
  RecordOfB().report.host = "there";
  EXPECT_THAT(AnswerTo(restart), Optional(IsRefused(Refusal::kOnAnotherHost)));
  b_.host = "vision";
  EXPECT_THAT(AnswerTo(restart), Optional(IsRefused(Refusal::kNoUnitOfHost)));
  b_.host.clear();
  RecordOfB().process.pid = 9;  // our own one waits
  RecordOfB().other.emplace().host = "here";
  EXPECT_THAT(AnswerTo(restart), Optional(IsRefused(Refusal::kOnAnotherHost)));
  machine_.phase = Phase::kStopped;
  EXPECT_THAT(AnswerTo(restart), Optional(IsRefused(Refusal::kNotRestartable)));
}

TEST_F(RefusedPlans, OfAReleaseWithoutAStopOrOfAStoppedMachine) {
  const event::ReleaseRequested release{7, "alice"};
  EXPECT_THAT(AnswerTo(release), Optional(IsRefused(Refusal::kNoEmergencyStop)));
  machine_.phase = Phase::kStopped;
  EXPECT_THAT(AnswerTo(release), Optional(IsRefused(Refusal::kStoppedMachine)));
}

TEST_F(RefusedPlans, OfAReleaseByAPersonWhoHasNotSeenAllStops) {
  machine_.emergency.stop = EmergencyStop{5, "alice", "a person"};
  machine_.emergency.others = {{6, "bob", "a child"}};
  const event::ReleaseRequested release{7, "alice", {StopId(5)}};
  EXPECT_THAT(AnswerTo(release), Optional(IsRefused(Refusal::kStopNotSeen)));
}

TEST_F(RefusedPlans, OfAReleaseDuringWhichTheMachineWasStoppedAgain) {
  machine_.emergency.stop = EmergencyStop{8, "bob", ""};
  machine_.emergency.release.emplace().requests = {7};
  EXPECT_THAT(AnswerTo(event::TimePassed{}), Optional(IsRefused(Refusal::kStoppedAgain)));
}

class RefusedSwitches : public Switching {
 protected:
  // The answer to a switch to Active that waits for c, until `meanwhile`.
  SwitchResult OfAWaitingOne(const std::function<void(Harness&)>& meanwhile) {
    Harness& t = In("LowPower");
    t.On("c", "LowPower").takes = Milliseconds(80);
    t.Crash("c");
    t.RunFor(Milliseconds(1));
    t.StartActuator("c");
    EXPECT_TRUE(t.RunUntil([&] {
      const auto& command = t.RecordOf("c").command;
      return command && command->target == "LowPower";
    }));
    const RequestId waiting = t.RequestSwitch("Active");
    meanwhile(t);
    EXPECT_TRUE(t.RunUntil([&] { return t.answers.contains(waiting); }));
    return t.answers.at(waiting);
  }
};

TEST_F(RefusedSwitches, OfAnUnknownActuator) {
  EXPECT_THAT(In("Active").Set("LowPower", "tail"), IsRefused(Refusal::kUnknownActuator));
}

TEST_F(RefusedSwitches, WhileAnotherOneIsUnderWayOrWaits) {
  Harness& t = In("Active");
  t.RequestSwitch("LowPower");
  EXPECT_THAT(t.Set("DeActive"), IsRefused(Refusal::kSwitchUnderWay));
  OfAWaitingOne([](Harness& waits) {
    EXPECT_THAT(waits.Set("DeActive"), IsRefused(Refusal::kSwitchWaiting));
  });
}

TEST_F(RefusedSwitches, ThatWaitWhenAMoreUrgentOneOrAnotherControllerComes) {
  EXPECT_THAT(OfAWaitingOne([](Harness& t) { t.RequestSwitch("Error"); }),
              IsRefused(Refusal::kSwitchStartedFirst));
  EXPECT_THAT(OfAWaitingOne([](Harness& t) { t.ReceiveRivalHeartbeat(9); }),
              IsRefused(Refusal::kLedByRival));
}

TEST_F(RefusedSwitches, OfAManagerAgainstTheRequestOfAPerson) {
  Harness& t = In("Active");
  ASSERT_TRUE(t.Set("DeActive", std::nullopt, {"alice@dog1", false}).done());
  EXPECT_THAT(t.Set("Active", std::nullopt, {"/lifecycle_manager", true}),
              IsRefused(Refusal::kRequestedByAnother));
}

TEST_F(RefusedSwitches, OfAManagerAfterAnEmergencyStopThatIsReleased) {
  Harness& t = In("Active");
  ASSERT_TRUE(t.Set("DeActive", std::nullopt, {"/lifecycle_manager", true}).done());
  t.StopAll(StopId(7));
  t.Release();
  t.RunFor(Milliseconds(100));
  EXPECT_THAT(t.Set("Active", std::nullopt, {"/lifecycle_manager", true}),
              IsRefused(Refusal::kStopAwaitsPerson));
}

TEST(ARequestThatAwaitsTheSetUp, IsRefusedWhenTheMachineIsTornDownFirst) {
  Harness t(MachineOf(2));
  t.On("a", "SetUp").hangs = true;
  t.Begin();
  const RequestId awaits(900);
  t.Feed(event::SetUpAwaited{awaits});
  t.RequestSwitch("TearDown");
  ASSERT_TRUE(t.RunUntil([&] { return t.calls.contains(awaits); }));
  ASSERT_FALSE(t.calls.at(awaits).ok());
  EXPECT_THAT(t.calls.at(awaits).error(), IsRefused(Refusal::kBeingTornDown));
}

class RefusedByPolicy : public Rules {
 protected:
  // The error of a request that is answered at once.
  Error ErrorOf(RequestId request) {
    const auto answer = robot().calls.find(request);
    const bool refused = answer != robot().calls.end() && !answer->second.ok();
    EXPECT_TRUE(refused) << "not refused at once";
    return refused ? answer->second.error() : Error{};
  }
};

TEST_F(RefusedByPolicy, WhereTheConfigHasNoTableForIt) {
  Robot("Active", MachineOf(2));
  EXPECT_THAT(ErrorOf(RequestPolicy(PolicyRequest::kWakeUp)), IsRefused(Refusal::kNoPolicy));
  MachineConfig config = WithPolicy();
  config.policy->low_power.reset();
  Robot("Active", config);
  EXPECT_THAT(ErrorOf(RequestPolicy(PolicyRequest::kLowPowerSwitch)),
              IsRefused(Refusal::kNoLowPowerPolicy));
}

TEST_F(RefusedByPolicy, AKeepThatIsImpossibleOrThatAnotherKeepForbids) {
  Robot();
  EXPECT_THAT(ErrorOf(Keep("Protected", -1)), IsRefused(Refusal::kKeepOutOfRange));
  EXPECT_THAT(ErrorOf(Keep("", 0)), IsRefused(Refusal::kNothingKept));
  EXPECT_EQ(KeepAndWait("Protected", 60), "ok");
  EXPECT_THAT(ErrorOf(Keep("LowPower", 60)), IsRefused(Refusal::kKept));
}

TEST_F(RefusedByPolicy, WhatTheStateDoesNotPermit) {
  Robot();
  EXPECT_THAT(ErrorOf(RequestPolicy(PolicyRequest::kOta, false)), IsRefused(Refusal::kNotInOta));
  EXPECT_THAT(ErrorOf(RequestPolicy(PolicyRequest::kWakeUp)), IsRefused(Refusal::kNotInLowPower));
  Robot("OTA");
  EXPECT_THAT(ErrorOf(Keep("Active", 0)), IsRefused(Refusal::kInOta));
}

class RefusedCommands : public OneActuator {
 protected:
  RefusedCommands() { SetUpIt(); }

  using Arrived = actuator_event::SwitchArrived;
  actuator_action::Answer AnswerTo(const ActuatorEvent& event) { return AnswerIn(Do(event)); }
};

TEST_F(RefusedCommands, OfASenderThatIsNotObeyed) {
  Switch(1, "Active");
  Arrived unknown = Command(2, "DeActive");
  unknown.sender = 0;
  EXPECT_THAT(AnswerTo(unknown), IsRefused(Refusal::kSenderUnknown));
  Arrived other = Command(2, "DeActive");
  other.sender = 99;
  EXPECT_THAT(AnswerTo(other), IsRefused(Refusal::kEpochOfAnother));
  EXPECT_THAT(AnswerTo(Command(2, "DeActive", Epoch(kLastEpoch.value() + 1))),
              IsRefused(Refusal::kEpochOutOfRange));
  Arrived outdated = Command(2, "DeActive", 0);
  outdated.sender = 1;
  EXPECT_THAT(AnswerTo(outdated), IsRefused(Refusal::kEpochOutdated));
  EXPECT_THAT(AnswerTo(Command(2, "DeActive", 5)), IsRefused(Refusal::kNotAnnounced));
}

TEST_F(RefusedCommands, ThatComeTooLateOrElsewhere) {
  Switch(5, "Active");
  EXPECT_THAT(AnswerTo(Command(4, "DeActive")), IsRefused(Refusal::kCommandOutdated));
  Arrived old = Command(6, "DeActive");
  old.command.status_stamp = now_ - std::chrono::seconds(1);
  EXPECT_THAT(AnswerTo(old), IsRefused(Refusal::kCommandTooOld));
  Arrived ageless = Command(6, "DeActive");
  ageless.command.status_stamp = now_ + std::chrono::seconds(1);
  EXPECT_THAT(AnswerTo(ageless), IsRefused(Refusal::kCommandWithoutAge));
  Arrived elsewhere = Command(7, "DeActive");
  elsewhere.command.incarnation = 78;
  EXPECT_THAT(AnswerTo(elsewhere), IsRefused(Refusal::kOtherProcess));
}

TEST_F(RefusedCommands, ThatWaitUntilSomethingElseComesFirst) {
  Do(Command(1, "Active"));
  Do(Command(2, "DeActive"));
  EXPECT_THAT(AnswerTo(Command(3, "LowPower")), IsRefused(Refusal::kCommandReplaced));
  EXPECT_THAT(AnswerTo(actuator_event::QueryArrived{9, {1, 3, false}, 1}),
              IsRefused(Refusal::kCommandCancelled));
  Do(Command(4, "DeActive"));
  Announce(2);
  EXPECT_THAT(AnswerTo(actuator_event::QueryArrived{9, {2, 4, false}, 2}),
              IsRefused(Refusal::kTakenOver));
}

TEST_F(RefusedCommands, AfterTheTearDown) {
  Do(Command(1, "TearDown"));
  Do(Command(2, "Active"));
  const auto answers = AnswersIn(Do(actuator_event::CallbackEnded{}));
  ASSERT_EQ(answers.size(), 2U);
  EXPECT_THAT(answers.back(), IsRefused(Refusal::kActuatorEnds));
  EXPECT_THAT(AnswerTo(Command(3, "Active")), IsRefused(Refusal::kActuatorTornDown));
}

TEST_F(RefusedCommands, ToAStateThatCannotBeCommanded) {
  EXPECT_THAT(AnswerTo(Command(1, "SetUp")), IsRefused(Refusal::kOnlyAtStart));
  EXPECT_THAT(AnswerTo(Command(2, "OTA")), IsRefused(Refusal::kStateMissing));
  Do(actuator_event::EmergencyStopReceived{7, true, 0, "alice"});
  EXPECT_THAT(AnswerTo(Command(3, "Active")), IsRefused(Refusal::kStopForbidsSwitchingOn));
  Do(actuator_event::EmergencyStopReceived{7, false, 1, "", "", 5});
  EXPECT_THAT(AnswerTo(Command(5, "Active")), IsRefused(Refusal::kCommandBeforeRelease));
}

TEST_F(RefusedCommands, OfAManagerWhileItIsBusyOrAControllerHasControl) {
  Do(actuator_event::ManagerCommand{1, "Active"});
  EXPECT_THAT(AnswerTo(actuator_event::ManagerCommand{2, "DeActive"}), IsRefused(Refusal::kBusy));
  Do(actuator_event::CallbackEnded{});
  Switch(1, "DeActive");
  EXPECT_THAT(AnswerTo(actuator_event::ManagerCommand{3, "Active"}),
              IsRefused(Refusal::kControlled));
}

TEST_F(RefusedCommands, OfAManagerBeforeTheFirstPermit) {
  config_.permit = Milliseconds(500);
  core_.permit.first_by = now_ + std::chrono::seconds(1);
  EXPECT_THAT(AnswerTo(actuator_event::ManagerCommand{1, "Active"}),
              IsRefused(Refusal::kNoPermitYet));
}

TEST(ARefusedCapability, HasTheReason) {
  const MachineConfig config = [] {
    MachineConfig made = MachineOf(2);
    made.capabilities = {{"jump", "", {"a"}, {"Active"}, 30}};
    return made;
  }();
  const auto why = [&](const CapabilityView& view) {
    const Result<> allowed = EvaluateCapability(config, "jump", view);
    return allowed ? Error{kCodeOk, "allowed"} : allowed.error();
  };
  EXPECT_THAT(why({"b", "Active", "", false, 90}), IsRefused(Refusal::kNotDeclared));
  EXPECT_THAT(why({"a", "Active", "", true, 90}), IsRefused(Refusal::kStopForbidsCapability));
  EXPECT_THAT(why({"a", "Active", "", false, 90, true}), IsRefused(Refusal::kHeldByReleasedStop));
  EXPECT_THAT(why({"a", "LowPower", "", false, 90}), IsRefused(Refusal::kNotInThisState));
  EXPECT_THAT(why({"a", "Active", "LowPower", false, 90}), IsRefused(Refusal::kNotWhileSwitching));
  EXPECT_THAT(why({"a", "Active", "", false, 29}), IsRefused(Refusal::kBatteryTooLow));
  EXPECT_THAT(why({"a", "Active", "", false, std::nullopt}), IsRefused(Refusal::kBatteryUnknown));
}

TEST(ARefusedTransition, IsUnknownOrDoesNotBeginInTheStateOfTheNode) {
  ManagedNode node;
  node.Observe("SetUp", "");
  EXPECT_THAT(node.Begin(77, "").error(), IsRefused(Refusal::kUnknownTransition));
  EXPECT_THAT(node.Begin(0, "activate").error(), IsRefused(Refusal::kTransitionImpossible));
}

}  // namespace musher::testing::refusal_test
