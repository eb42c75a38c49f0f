// Which controller leads the machine, and how a controller handles invalid status and replies.

#include <gmock/gmock.h>

#include <limits>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::authority_test {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class Authority : public Switching {
 protected:
  // The report of an actuator, changed a little.
  template <typename Change>
  static void Say(Harness& t, const std::string& name, Change change) {
    ActuatorReport report = t.CoreOf(name).report;
    report.stamp = t.now();
    change(report);
    t.Feed(event::StatusSeen{*t.config().IndexOf(name), report});
  }
};

// Another controller

TEST_F(Authority, AControllerWithAHigherEpochTakesOverAtOnce) {
  Harness& t = In("Active", Ours(3));
  t.ReceiveRivalHeartbeat(t.machine().epoch + 1);
  ASSERT_TRUE(t.fenced);
  EXPECT_THAT(*t.fenced, HasSubstr("process 1 elsewhere"));
  EXPECT_EQ(t.machine().phase, Phase::kFenced);
  EXPECT_FALSE(NextDeadline(t.config(), t.machine()));
}

TEST_F(Authority, AControllerWithALowerOrInvalidEpochIsIgnored) {
  Harness& t = In("Active");
  t.RestartController();
  t.Rest();
  t.ReceiveRivalHeartbeat(t.machine().epoch - 1);
  t.ReceiveRivalHeartbeat(t.machine().epoch);  // without precedence
  t.ReceiveRivalHeartbeat(Epoch(std::numeric_limits<std::uint64_t>::max()));
  EXPECT_FALSE(t.fenced);
  t.Feed(event::RivalSeen{t.machine().epoch, "process 2", true});
  EXPECT_TRUE(t.fenced);
}

// A laptop takes over and engages a stop, which is on its disk alone. Once the robot's power was
// cut, the controller of the robot went to Active at boot.
TEST_F(Authority, AControllerThatAnotherHostReplacesKeepsTheNextBootFromSwitchingOn) {
  Harness& t = In("Active", Ours(2));
  t.Feed(event::RivalSeen{t.machine().epoch + 1, "process 2 of host laptop", false, true});
  ASSERT_EQ(t.machine().phase, Phase::kFenced);
  t.RunFor(Milliseconds(1));  // the disk
  EXPECT_TRUE(t.disk().stops.led_elsewhere);
  for (const bool by_supervisor : {true, false}) {
    SCOPED_TRACE(by_supervisor ? "started by a supervisor" : "started by a person");
    Harness next(Ours(2));
    next.disk() = t.disk();
    next.Begin(false, t.disk().epoch, /*restarted=*/by_supervisor);
    next.Rest();
    EXPECT_EQ(next.machine().state, by_supervisor ? kSetUp : kActive);
    EXPECT_FALSE(next.disk().stops.led_elsewhere);
    EXPECT_EQ(next.disk().stops.awaits_request, by_supervisor);
    EXPECT_TRUE(next.Set("SelfCheck").done());
    EXPECT_TRUE(next.Set("Active").done());
    next.Rest();
    EXPECT_FALSE(next.disk().stops.awaits_request) << "the next boot starts it";
  }
}

// The next controller has the same folder, with all stops.
TEST_F(Authority, AControllerThatAnotherOneOfItsHostReplacesLeavesNoNoteOfThat) {
  Harness& t = In("Active", Ours(2));
  t.ReceiveRivalHeartbeat(t.machine().epoch + 1);
  ASSERT_EQ(t.machine().phase, Phase::kFenced);
  t.RunFor(Milliseconds(1));
  EXPECT_FALSE(t.disk().stops.led_elsewhere);
}

TEST_F(Authority, EveryCallerIsAnsweredWhenTheControllerIsFenced) {
  Harness& t = In("Active", Ours(3));
  t.On("b", "LowPower").takes = Milliseconds(80);
  const RequestId one = t.RequestSwitch("LowPower");
  const RequestId same = t.RequestSwitch("LowPower");
  t.Crash("c");
  const RequestId restart = t.Restart("a");
  t.RunFor(Milliseconds(1));
  t.ReceiveRivalHeartbeat(99);
  for (const RequestId request : {one, same}) {
    ASSERT_EQ(t.answers.count(request), 1U);
    EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kSuperseded);
    EXPECT_EQ(t.answers.at(request).code, kCodePermissionDenied);
  }
  ASSERT_EQ(t.calls.count(restart), 1U);
  EXPECT_EQ(t.calls.at(restart).error().code, kCodePermissionDenied);
}

TEST_F(Authority, EveryCallerThatWaitsForTheEndIsAnsweredTooAlsoAfterTheTearDown) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "TearDown").code = 3001;
  t.On("b", "TERM").hangs = true;
  const RequestId request = t.RequestSwitch("TearDown");
  t.RunFor(std::chrono::seconds(2));
  ASSERT_FALSE(t.machine().current);
  ASSERT_EQ(t.answers.count(request), 0U);
  t.ReceiveRivalHeartbeat(99);
  EXPECT_EQ(t.answers.count(request), 1U);
  t.signals.clear();
  t.Rest();
  EXPECT_THAT(t.signals, IsEmpty());
}

TEST_F(Authority, AFencedControllerChangesNothingAndRefusesEveryRequest) {
  Harness& t = In("Active", Ours(3));
  t.StopAll(5);
  t.Find("b", Health::kHung);
  t.RunFor(Milliseconds(10));
  t.ReceiveRivalHeartbeat(99);
  const Machine before = t.machine();
  t.Crash("a");
  t.StopAll(6);
  t.StartActuator("c");
  t.Rest();
  EXPECT_THAT(t.signals, IsEmpty()) << "the hung one is another's to kill";
  EXPECT_EQ(t.machine(), before);
  EXPECT_EQ(t.Set("LowPower").code, kCodePermissionDenied);
  EXPECT_EQ(t.calls.at(t.Restart("a")).error().code, kCodePermissionDenied);
  EXPECT_EQ(t.calls.at(t.Release()).error().code, kCodePermissionDenied);
  t.Feed(event::SetUpAwaited{777});
  EXPECT_EQ(t.calls.at(777).error().code, kCodePermissionDenied);
  EXPECT_FALSE(t.disk().stops.engaged.empty()) << "not released by a controller that does not lead";
}

TEST_F(Authority, AControllerReceivedBeforeItsEpochIsExceededLeads) {
  Harness& t = In("Active");
  t.RestartController();
  t.Rest();
  t.RestartController(/*lost_disk=*/true);
  t.RunFor(Milliseconds(1000));
  EXPECT_EQ(t.machine().epoch, Epoch(1)) << "another controller may lead with it";
  t.ReceiveRivalHeartbeat(2);
  t.Rest();
  EXPECT_TRUE(t.fenced);
  EXPECT_EQ(t.CoreOf("a").report.epoch, Epoch(2)) << "no actuator was commanded";
}

// Modules with invalid status and replies

TEST_F(Authority, AReplyThatContradictsTheReportedStateIsAFailure) {
  Harness& t = In("Protected");
  const RequestId request = t.RequestSwitch("Active");
  ActuatorReport report = t.CoreOf("b").report;
  report.stamp = t.now();
  t.Feed(event::Replied{1, t.RecordOf("b").command->number, false, Verdict::kDone, 0, "", report});
  t.Rest();
  const SwitchResult& result = t.answers.at(request);
  EXPECT_EQ(result.outcome, SwitchOutcome::kUndone);
  EXPECT_EQ(Of(result, "b").code, kCodeStatusError);
  EXPECT_EQ(Of(result, "b").message, texts::ContradictedBy("Protected").message);
}

TEST_F(Authority, AStatusThatContradictsItsOutcomeIsAFailure) {
  Harness& t = In("Protected");
  const RequestId request = t.RequestSwitch("Active");
  Say(t, "b", [&](ActuatorReport& report) {
    report.outcome_number = t.RecordOf("b").command->number;
    report.outcome_code = kCodeOk;
  });
  t.Rest();
  EXPECT_EQ(t.answers.at(request).outcome, SwitchOutcome::kUndone);
}

TEST_F(Authority, AnActuatorThatChangesItsStateByItselfIsRecordedAndDrivenBack) {
  Harness& t = In("Active");
  Say(t, "b", [](ActuatorReport& report) { report.state = "LowPower"; });
  EXPECT_THAT(t.records, Contains(Is(texts::ActuatorDrifted("b", "LowPower", std::nullopt))));
  t.Rest();
  EXPECT_EQ(t.RecordOf("b").state(), "Active");
}

TEST_F(Authority, AnActuatorThatTearsItselfDownIsListedWithWhatBringsItBack) {
  Harness& t = In("Active");
  Say(t, "b", [](ActuatorReport& report) { report.state = "TearDown"; });
  ASSERT_TRUE(t.RecordOf("b").fault);
  EXPECT_EQ(t.RecordOf("b").fault->code, kCodeStateInvalid);
  EXPECT_EQ(t.RecordOf("b").fault->event, EventName::kTornDownAlone);
}

TEST(Drift, IsNotSeenInAStart) {
  Harness t(Ours(2));
  t.Begin();
  t.Rest();
  EXPECT_THAT(t.records, Not(Contains(Is(EventName::kActuatorDrifted))));
}

TEST_F(Authority, AnActuatorOfTheSameNameOnAnotherHostIsIgnoredWhileTheFirstAnswers) {
  Harness& t = In("Active");
  const ActuatorReport before = t.RecordOf("b").report;
  Say(t, "b", [](ActuatorReport& report) {
    report.host = "elsewhere";
    report.incarnation += 1000;
    report.state = "LowPower";
  });
  EXPECT_EQ(t.RecordOf("b").report, before);
  EXPECT_THAT(t.records,
              Contains(Is(texts::DuplicateActuator("b", before.pid, "elsewhere", before.pid))));
  t.Feed(event::Vanished{1, before.incarnation + 1000, false, "connection lost"});
  EXPECT_EQ(t.RecordOf("b").presence, Presence::kPresent);
  EXPECT_TRUE(t.Set("LowPower").done());
}

// Its status is latched: it was published once, while the process from before the reboot still
// counted.
TEST_F(Authority, AnActuatorOfARebootedHostIsUsedWhenItsPreviousProcessIsLost) {
  Harness& t = In("Active");
  Say(t, "b", [](ActuatorReport& report) {
    report.host = "the host's next boot";
    report.incarnation = 1;  // its clock has restarted
    report.epoch = 0;
    report.state = "SetUp";
  });
  EXPECT_EQ(t.RecordOf("b").presence, Presence::kPresent);
  t.Find("b", Health::kPartitioned, true);
  EXPECT_EQ(t.RecordOf("b").presence, Presence::kStarting);
  EXPECT_EQ(t.RecordOf("b").report.incarnation, Incarnation(1));
  EXPECT_EQ(t.RecordOf("b").control.incarnation, Incarnation(1));
}

TEST_F(Authority, ALostActuatorOfAnotherHostIsNotUsed) {
  Harness& t = In("Active");
  const ActuatorReport before = t.RecordOf("b").report;
  Say(t, "b", [](ActuatorReport& report) {
    report.host = "elsewhere";
    report.incarnation = 1;
  });
  t.Feed(event::Vanished{1, 1, false, "connection lost"});
  t.Find("b", Health::kPartitioned, true);
  EXPECT_EQ(t.RecordOf("b").report.incarnation, before.incarnation);
}

TEST_F(Authority, IncarnationsOfUnknownHostsAreNotCompared) {
  Harness& t = In("Active");
  t.Find("b", Health::kPartitioned, true);
  Say(t, "b", [](ActuatorReport& report) {
    report.host = "";
    report.incarnation -= 1;
  });
  EXPECT_NE(t.RecordOf("b").presence, Presence::kLost);
}

TEST_F(Authority, AnAnswerOfAnotherProcessIsIgnored) {
  Harness& t = In("Active");
  const RequestId request = t.RequestSwitch("LowPower");
  ActuatorReport report = t.CoreOf("b").report;
  report.incarnation += 1;
  report.state = "LowPower";
  t.Feed(
      event::Replied{1, t.RecordOf("b").command->number, false, Verdict::kFailed, 5, "", report});
  t.Rest();
  EXPECT_TRUE(t.answers.at(request).done());
}

TEST_F(Authority, AnEpochOutOfRangeIsNotUsedForAllActuators) {
  Harness& t = In("Active");
  t.Find("b", Health::kPartitioned, true);
  const Epoch epoch = t.machine().epoch;
  for (const Epoch absurd : {kLastEpoch, Epoch(std::numeric_limits<std::uint64_t>::max())}) {
    Say(t, "b", [&](ActuatorReport& report) { report.epoch = absurd; });
    t.RunFor(std::chrono::seconds(10));
    EXPECT_EQ(t.machine().epoch, epoch);
    EXPECT_THAT(t.RecordOf("b").fault, Is(texts::EpochOutOfRange(absurd)));
  }
  EXPECT_EQ(t.Set("LowPower").outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(t.StateOf("a"), "LowPower");
}

TEST_F(Authority, ANumberOutOfRangeDoesNotBlockTheCounter) {
  Harness& t = In("Active");
  Say(t, "b", [](ActuatorReport& report) {
    report.number = CommandNumber(std::numeric_limits<std::uint64_t>::max());
  });
  const SwitchResult result = t.Set("LowPower");
  EXPECT_LT(result.number, CommandNumber(1000));
  EXPECT_EQ(t.StateOf("a"), "LowPower");
}

TEST_F(Authority, AnOutdatedStatusChangesNothing) {
  Harness& t = In("Active");
  const Machine before = t.machine();
  Say(t, "b", [&](ActuatorReport& report) {
    report.stamp -= std::chrono::seconds(1);
    report.state = "LowPower";
  });
  Say(t, "b", [&](ActuatorReport& report) { report.incarnation -= 1; });
  EXPECT_EQ(t.machine(), before);
}

TEST_F(Authority, AnActuatorWhoseClockJumpsIsNotLost) {
  Harness& t = In("Active");
  Say(t, "b", [](ActuatorReport& report) { report.stamp += std::chrono::hours(24); });
  t.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(t.RecordOf("b").presence, Presence::kPresent);
  const SwitchResult result = t.Set("LowPower");
  EXPECT_NE(result.outcome, SwitchOutcome::kRefused);
  EXPECT_EQ(t.StateOf("a"), "LowPower");
}

}  // namespace musher::testing::authority_test
