// Processes that a release of the emergency stops waits for although they are not in use: a second
// process of an actuator, and one that was found running and has not announced itself.

#include "musher/test/lifecycle/coordination/one_controller.hpp"

namespace musher::testing::release_confirmed_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr StopId kStop = 5;
constexpr StopId kNone = 0;

class ReleaseConfirmed : public OneController {
 protected:
  // The process in use reports what it has latched, and the last release that it has received.
  void SayStops(ActuatorIndex i, StopId latched, StopId released) {
    now_ += Milliseconds(1);
    ActuatorReport report = Of(i).report;
    report.stamp = now_;
    report.emergency_stop = latched;
    report.released_stop = released;
    report.held_by_stop = true;
    Say(i, report);
  }
  // Of the process of actuator a after a reboot of its host. The one from before counts as present
  // until its heartbeat is missed.
  ActuatorReport Rebooted(StopId latched) {
    ActuatorReport report = Report(0);
    report.host = "here, after a reboot";
    report.incarnation = 1;
    report.pid = 12;
    report.epoch = 0;
    report.emergency_stop = latched;
    return report;
  }
  // Both are Active, and a stop was engaged and released.
  void StartUpAndRelease() {
    StartUp();
    Do(event::EmergencyStopSeen{{kStop, "a panel", "smoke"}});
    for (ActuatorIndex i = 0; i < 2; ++i) SayStops(i, kStop, kNone);
    Do(event::ReleaseRequested{1, "a person"});
    for (ActuatorIndex i = 0; i < 2; ++i) SayStops(i, kNone, kStop);
    ASSERT_THAT(Did<action::AnswerCall>(), SizeIs(1));
    ASSERT_TRUE(Did<action::AnswerCall>()[0].result);
    Forget();
  }
};

// The panel publishes the stop until it is switched off. "Released" was reported while the process
// of the rebooted host had latched it.
TEST_F(ReleaseConfirmed, BySecondProcessesToo) {
  StartUpAndRelease();
  Say(0, Rebooted(kStop));
  ASSERT_EQ(Of(0).presence, Presence::kPresent);
  ASSERT_TRUE(Of(0).other);
  EXPECT_FALSE(machine_.emergency.stop) << "it is released";
  Do(event::ReleaseRequested{2, "a person"});
  EXPECT_THAT(Did<action::AnswerCall>(), IsEmpty());

  Do(event::Vanished{0, kFirst, false, kOutOfReach});
  ASSERT_EQ(Of(0).report.incarnation, Incarnation(1)) << "it is in use now";
  EXPECT_THAT(Did<action::AnswerCall>(), IsEmpty());
  ActuatorReport report = Of(0).report;
  report.epoch = machine_.epoch;
  Do(event::Replied{0, report.number, true, Verdict::kDone, kCodeOk, "", report});
  ASSERT_EQ(Of(0).presence, Presence::kPresent);
  EXPECT_THAT(Did<action::AnswerCall>(), IsEmpty());
  SayStops(0, kNone, kStop);
  ASSERT_THAT(Did<action::AnswerCall>(), SizeIs(1));
  EXPECT_TRUE(Did<action::AnswerCall>()[0].result);
}

TEST_F(ReleaseConfirmed, NamesAnActuatorWhoseSecondProcessStaysStopped) {
  StartUpAndRelease();
  Say(0, Rebooted(kStop));
  Do(event::ReleaseRequested{2, "a person"});
  Pass(Milliseconds(3000));
  ASSERT_THAT(Did<action::AnswerCall>(), SizeIs(1));
  EXPECT_THAT(Did<action::AnswerCall>()[0].result.error().message, HasSubstr("not confirmed by a"));
}

TEST_F(ReleaseConfirmed, ByNoSecondProcessThatHasEnded) {
  StartUpAndRelease();
  Say(0, Rebooted(kStop));
  Do(event::ReleaseRequested{2, "a person"});
  Do(event::Vanished{0, 1, true, "its process 12 ended"});
  ASSERT_THAT(Did<action::AnswerCall>(), SizeIs(1));
  EXPECT_TRUE(Did<action::AnswerCall>()[0].result);
}

// The controller's own process is not in use, since one of another host is. It waits for its exit,
// which the kernel reports before the writer is lost, if that is reported at all.
TEST_F(ReleaseConfirmed, ByNoSecondProcessOfTheControllerThatHasExited) {
  StartUpAndRelease();
  Of(0).process.pid = 700;
  Of(0).report.host = "there";
  Of(0).report.pid = 900;
  ActuatorReport second = Report(0, kActive);
  second.incarnation = kFirst + 10;
  second.epoch = 0;
  second.emergency_stop = kStop;
  Say(0, second);
  ASSERT_TRUE(Of(0).other);
  Do(event::ReleaseRequested{2, "a person"});
  ASSERT_THAT(Did<action::AnswerCall>(), IsEmpty());
  Do(event::ProcessEnded{0, 700, false, "exit code 1"});
  ASSERT_EQ(Of(0).presence, Presence::kPresent) << "the other one is in use";
  ASSERT_THAT(Did<action::AnswerCall>(), SizeIs(1));
  EXPECT_TRUE(Did<action::AnswerCall>()[0].result);
}

// A process with the pid of the one that has exited, on another host.
TEST_F(ReleaseConfirmed, BySecondProcessesOfAnotherHostWithTheSamePidAsAProcessThatHasExited) {
  StartUpAndRelease();
  Of(0).process.pid = 12;
  Of(0).report.pid = 900;
  Say(0, Rebooted(kStop));
  ASSERT_EQ(Of(0).other.value().pid, 12);
  Do(event::ReleaseRequested{2, "a person"});
  Do(event::ProcessEnded{0, 12, false, "exit code 1"});
  EXPECT_THAT(Did<action::AnswerCall>(), IsEmpty());
}

// Its status stays: a process that was torn down, or that has failed to set up, may take a while to
// exit.
TEST_F(ReleaseConfirmed, ByNoSecondProcessThatWasTornDownOrNotSetUp) {
  for (const bool torn_down : {true, false}) {
    StartUpAndRelease();
    Say(0, Rebooted(kStop));
    ASSERT_TRUE(Of(0).other);
    Do(event::ReleaseRequested{2, "a person"});
    ASSERT_THAT(Did<action::AnswerCall>(), IsEmpty());
    ActuatorReport over = Rebooted(kStop);
    over.state = torn_down ? State(kTearDown) : config_.default_state;
    over.outcome_code = torn_down ? kCodeOk : kCodeFailed;
    now_ += Milliseconds(1);
    over.stamp = now_;
    Say(0, over);
    ASSERT_THAT(Did<action::AnswerCall>(), SizeIs(1)) << torn_down;
    EXPECT_TRUE(Did<action::AnswerCall>()[0].result) << torn_down;
  }
}

// The one in use was replaced, and its successor is not set up yet: the second one was forgotten.
TEST_F(ReleaseConfirmed, BySecondProcessesTooWhileTheOneInUseStarts) {
  StartUpAndRelease();
  Say(0, Rebooted(kStop));
  ASSERT_TRUE(Of(0).other);
  ActuatorReport successor = Report(0, config_.default_state);
  successor.incarnation = kFirst + 10;
  successor.epoch = 0;
  Say(0, successor);
  ASSERT_EQ(Of(0).presence, Presence::kStarting);
  ASSERT_EQ(Of(0).report.emergency_stop, kNone);
  Do(event::ReleaseRequested{2, "a person"});
  EXPECT_THAT(Did<action::AnswerCall>(), IsEmpty());
}

TEST_F(ReleaseConfirmed, ByTheLastStatusOfASecondProcessAndNotByAnOlderOneBehindIt) {
  StartUpAndRelease();
  ActuatorReport older = Rebooted(kStop);
  now_ += Milliseconds(1);
  Say(0, Rebooted(kNone));
  Say(0, older);
  Do(event::ReleaseRequested{2, "a person"});
  ASSERT_THAT(Did<action::AnswerCall>(), SizeIs(1));
  EXPECT_THAT(Did<action::AnswerCall>()[0].result.error().message,
              HasSubstr("no emergency stop is engaged"));
}

// The stop of a panel that has ended, or its own for want of a permit: nothing else publishes it.
TEST_F(ReleaseConfirmed, IsFollowedByAStopThatOnlyASecondProcessHasLatched) {
  StartUpAndRelease();
  Say(0, Rebooted(kStop + 1));
  ASSERT_TRUE(machine_.emergency.stop);
  EXPECT_EQ(machine_.emergency.stop->id, kStop + 1);
  const auto published = Did<action::PublishEmergencyStop>();
  ASSERT_THAT(published, SizeIs(1));
  EXPECT_TRUE(published[0].engaged);
}

// A new controller of the host has found it by its name, and gets its status later: it is stopped
// by SIGSTOP, say, or has not been discovered yet.
TEST_F(ReleaseConfirmed, ByAProcessThatWasFoundRunningOnceItHasAnnouncedItselfOrExited) {
  for (const bool exits : {true, false}) {
    machine_ = MakeMachine(config_);
    event::Begin begin{false, 0, {true, true}, "here"};
    begin.processes = {700, 701};
    begin.stops.engaged = {{kStop, "a panel", "smoke"}};
    Do(begin);
    Come(1, kActive);
    Do(event::ReleaseRequested{1, "a person"});
    Forget();
    SayStops(1, kNone, kStop);
    EXPECT_THAT(Did<action::AnswerCall>(), IsEmpty()) << "a may have latched it";
    if (exits) {
      Do(event::ProcessEnded{0, 700, false, "exit code unknown"});
    } else {
      ActuatorReport report = Report(0, kActive);
      report.emergency_stop = kStop;
      report.held_by_stop = true;
      Say(0, report);
      report.epoch = machine_.epoch;
      Do(event::Replied{0, report.number, true, Verdict::kDone, kCodeOk, "", report});
      EXPECT_THAT(Did<action::AnswerCall>(), IsEmpty()) << "it has not received the release yet";
      SayStops(0, kNone, kStop);
    }
    ASSERT_THAT(Did<action::AnswerCall>(), SizeIs(1)) << exits;
    EXPECT_TRUE(Did<action::AnswerCall>()[0].result);
  }
}

// It is no reason to release what nothing has engaged.
TEST_F(ReleaseConfirmed, IsRefusedWithoutAStopBesideAProcessThatWasFoundRunning) {
  machine_ = MakeMachine(config_);
  event::Begin begin{false, 0, {true, true}, "here"};
  begin.processes = {700, 701};
  Do(begin);
  Do(event::ReleaseRequested{1, "a person"});
  ASSERT_THAT(Did<action::AnswerCall>(), SizeIs(1));
  EXPECT_EQ(Did<action::AnswerCall>()[0].result.error().code, kCodeStateInvalid);
}

}  // namespace musher::testing::release_confirmed_test
