// The controller of another machine has begun on the host of an actuator, and has taken it. Its
// process is that one's to end, although this controller has started it.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/one_controller.hpp"

namespace musher::testing::taken_actuator_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::int32_t kPid = 700;  // of actuator 0, on host "board"
constexpr RequestId kRequest = 71;
constexpr const char* kHow = "it follows another machine now, cart";

class TakenProcesses : public OneController {
 protected:
  TakenProcesses() {
    config_.transport = TransportProfile::kLan;
    HostConfig& host = config_.hosts.emplace_back();
    host.name = "board";
    host.address = "10.0.0.2";
    config_.actuators[0].host = "board";
    config_.actuators[0].command = {"run", "a"};
    config_.actuators[0].restart.policy = RestartPolicy::kAlways;
    config_.actuators[0].on_lost = kDeActive;
  }
  ActuatorReport OnBoard(const State& state) {
    ActuatorReport report = Report(0, state);
    report.host = "board";
    report.pid = kPid;
    return report;
  }
  void ObeyBoth() {
    for (int rounds = 0; rounds < 10; ++rounds) {
      if (const auto command = Of(0).command) {
        ActuatorReport report = OnBoard(command->target);
        report.epoch = machine_.epoch;
        report.number = report.outcome_number = command->number;
        Do(event::Replied{0, command->number, false, Verdict::kDone, kCodeOk, "", report});
      }
      if (Of(1).command) Obey(1);
    }
  }
  // The controller has started it on the board, and leads both in Active.
  void Lead() {
    Begin();
    Do(event::ProcessStarted{0, kPid, "board"});
    ActuatorReport report = OnBoard(kSetUp);
    Say(0, report);
    report.epoch = machine_.epoch;
    report.number = Of(0).report.number;
    Do(event::Replied{0, report.number, true, Verdict::kDone, kCodeOk, "", report});
    Come(1);
    ObeyBoth();
    ASSERT_EQ(machine_.state, kActive);
    Forget();
  }
  void Take() { Do(event::Vanished{0, kFirst, false, kHow, true, kPid, "board"}); }
  void ExpectNoSignal() const {
    EXPECT_THAT(Did<action::SignalProcess>(), IsEmpty());
    EXPECT_THAT(Did<action::TakeBacktrace>(), IsEmpty());
  }
  // The machine is down without waiting for it, without a signal to it, and the answer names it.
  void ExpectLeftAloneByTearDown() {
    Do(event::SetStateRequested{kRequest, kTearDown, {}});
    ObeyAll();
    Pass(config_.shutdown_budget / 2);
    EXPECT_EQ(machine_.phase, Phase::kStopped);
    ExpectNoSignal();
    const auto answers = Did<action::AnswerSetState>();
    ASSERT_THAT(answers, SizeIs(1));
    const SwitchResult& result = answers.front().result;
    EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
    EXPECT_EQ(result.reason,
              "a: it follows another machine now, cart: its process 700 on host board is left to "
              "that machine");
    EXPECT_THAT(result.degraded, ElementsAre("a"));
  }
};

class TakenActuator : public TakenProcesses {
 protected:
  TakenActuator() {
    Lead();
    Take();
    ObeyAll();
  }
};

// A controller that could restart it waited for an exit that never came, in Active.
TEST_F(TakenActuator, TakesTheMachineToItsOnLost) {
  EXPECT_EQ(machine_.state, kDeActive);
  EXPECT_EQ(Of(0).presence, Presence::kLost);
}

// It was ended by SIGTERM, without TearDown, under the machine that leads it.
TEST_F(TakenActuator, IsLeftAloneAndNamedByTearDown) {
  ExpectLeftAloneByTearDown();
}

TEST_F(TakenActuator, IsLeftAloneByASearchThatFindsItAgain) {
  Do(event::SetStateRequested{kRequest, kTearDown, {}});
  event::ProcessesFound found;
  found.processes = {kPid, 0};
  found.hosts = {"board", ""};
  found.unreached = {"", ""};
  Do(found);
  ExpectNoSignal();
}

TEST_F(TakenActuator, IsNotKilledWhereItHangs) {
  Do(event::HealthChanged{0, kFirst, Health::kHung, true, "its work thread stands still"});
  Pass(std::chrono::seconds(30));
  ExpectNoSignal();
}

TEST_F(TakenActuator, IsNotEndedForARestartThatAPersonRequests) {
  Do(event::RestartRequested{kRequest, "a", "alice"});
  ASSERT_THAT(Did<action::StartProcess>(), SizeIs(1));
  Do(event::ProcessStarted{0, kPid, "board", true});  // it runs there already
  Take();
  ExpectNoSignal();
  const auto answers = Did<action::AnswerCall>();
  ASSERT_THAT(answers, SizeIs(1));
  ASSERT_FALSE(answers.front().result);
  EXPECT_EQ(answers.front().result.error().message, kHow);
  ExpectLeftAloneByTearDown();
}

// A request from before, whose TearDown had no answer, waited for ever.
TEST_F(TakenProcesses, EndARestartThatIsUnderWay) {
  Lead();
  Do(event::RestartRequested{kRequest, "a", "alice"});
  ASSERT_TRUE(Of(0).command);
  Take();
  ExpectNoSignal();
  const auto answers = Did<action::AnswerCall>();
  ASSERT_THAT(answers, SizeIs(1));
  EXPECT_FALSE(answers.front().result);
}

// Its exit is seen as that of any other process.
TEST_F(TakenActuator, IsStartedAgainOnceItsProcessHasExited) {
  Do(event::ProcessEnded{0, kPid, true, "exit code 0"});
  Pass(std::chrono::seconds(10));
  EXPECT_THAT(Did<action::StartProcess>(), SizeIs(1));
  EXPECT_FALSE(Of(0).process.taken);
}

TEST_F(TakenActuator, IsEndedByTearDownOnceItFollowsThisMachineAgain) {
  Say(0, OnBoard(kActive));
  EXPECT_FALSE(Of(0).process.taken);
  Do(event::SetStateRequested{kRequest, kTearDown, {}});
  EXPECT_THAT(Did<action::SignalProcess>(), ElementsAre(action::SignalProcess{0, kPid, false}));
}

// The controller that had led it was started again: it finds the process, and no status of it.
TEST_F(TakenProcesses, AreLeftAloneByAControllerThatOnlyFindsThem) {
  Begin();
  Come(1);
  Do(event::ProcessStarted{0, kPid, "board", true});
  Take();
  EXPECT_EQ(Of(0).presence, Presence::kLost);
  ASSERT_TRUE(Of(0).fault);
  EXPECT_EQ(Of(0).fault->message, kHow);
  ObeyAll();
  ExpectLeftAloneByTearDown();
}

// The link was cut while it was taken: its exit or its hang was awaited, in Active.
TEST_F(TakenProcesses, TakeTheMachineToItsOnLostAlsoWhereTheyWereOutOfReachMeanwhile) {
  Lead();
  Do(event::Vanished{0, kFirst, false, kOutOfReach});
  ASSERT_EQ(machine_.state, kActive);
  Take();
  ObeyAll();
  EXPECT_EQ(machine_.state, kDeActive);
  EXPECT_EQ(Of(0).fault->message, kHow);
  EXPECT_FALSE(Of(0).exit_by) << "it would take the machine there once more, against a person";
}

// A process of that pid on another host is not the one that this controller has started.
TEST_F(TakenProcesses, AreThoseOfTheirHostOnly) {
  Lead();
  Do(event::Vanished{0, kFirst + 100, false, kHow, true, kPid, "dock"});
  EXPECT_EQ(Of(0).presence, Presence::kPresent);
  EXPECT_FALSE(Of(0).fault);
}

}  // namespace musher::testing::taken_actuator_test
