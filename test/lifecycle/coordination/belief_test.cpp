// States in which the controller has acted on belief.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/one_controller.hpp"
#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::belief_test {

using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::Not;

class Adopted : public OneController {
 protected:
  Adopted() {
    for (ActuatorConfig& actuator : config_.actuators) {
      actuator.command = {"run", actuator.name};
      actuator.restart.policy = RestartPolicy::kOnFailure;
    }
  }
  void TakeOver() {
    machine_ = MakeMachine(config_);
    event::Begin begin{false, 0, {true, true}, "here"};
    begin.processes = {700, 701};
    Do(begin);
    for (ActuatorIndex i = 0; i < 2; ++i) Come(i, "Active");
    Forget();
  }
};

// A person has torn it down alone; its process has ended, and how is not known.
TEST_F(Adopted, AnActuatorWhoseTearDownEndedWithItsProcessIsNotSwitchedOnAgain) {
  TakeOver();
  Do(event::SetStateRequested{1, "TearDown", "a"});
  ASSERT_TRUE(Of(0).command);
  Do(event::ProcessEnded{0, 700, false, "exit code unknown"});
  Pass(std::chrono::seconds(60));
  EXPECT_THAT(Did<action::StartProcess>(), IsEmpty());
}

// It goes on as one that was lost and is back, and is not.
TEST_F(Switching, AnActuatorThatWasHeldAndIsBackFromASwitchDownIsNotLeftAboveTheMachine) {
  Harness& t = In("Active", MachineOf(2));
  ASSERT_TRUE(t.Set("Protected", "b").done());
  t.On("a", "LowPower").takes = Milliseconds(90);
  t.Mute("b", true, false);  // its command is lost
  const RequestId request = t.RequestSwitch("LowPower");
  t.RunFor(Milliseconds(20));
  t.Feed(event::Vanished{1, t.RecordOf("b").report.incarnation, false, "connection lost"});
  t.Mute("b", false, false);
  t.RunFor(Milliseconds(10));
  t.RepeatStatus("b");
  t.Rest();
  ASSERT_TRUE(t.answers.contains(request));
  EXPECT_EQ(t.machine().state, "LowPower");
  const bool listed = !Degraded(t.config(), t.machine()).empty();
  EXPECT_TRUE(t.StateOf("b") == "LowPower" || listed) << "it is in " << t.StateOf("b");
}

// Silence is failure.
TEST_F(Switching, ASelfCheckThatWasNotAnsweredIsListedAlsoWhenTheActuatorIsBack) {
  Harness& t = In("Active", MachineOf(2));
  t.On("a", "SelfCheck").takes = Milliseconds(90);
  t.On("b", "SelfCheck").code = kCodeFailed;
  t.On("b", "SelfCheck").takes = Milliseconds(50);
  const RequestId request = t.RequestSwitch("SelfCheck");
  t.RunFor(Milliseconds(20));
  t.Feed(event::Vanished{1, t.RecordOf("b").report.incarnation, false, "connection lost"});
  t.RunFor(Milliseconds(10));
  t.RepeatStatus("b");
  t.Rest();
  ASSERT_TRUE(t.answers.contains(request));
  EXPECT_EQ(Of(t.answers.at(request), "b").outcome, ActuatorOutcome::kLost);
  const bool listed = !Degraded(t.config(), t.machine()).empty();
  EXPECT_TRUE(t.RecordOf("b").checked || listed);
}
TEST_F(Switching, ASelfCheckThatWasLostIsRepeatedOrListedAlsoWhenTheActuatorIsBack) {
  Harness& t = In("Active", MachineOf(2));
  t.On("a", "SelfCheck").takes = Milliseconds(90);
  t.Mute("b", true, false);
  const RequestId request = t.RequestSwitch("SelfCheck");
  t.RunFor(Milliseconds(20));
  t.Feed(event::Vanished{1, t.RecordOf("b").report.incarnation, false, "connection lost"});
  t.Mute("b", false, false);
  t.RunFor(Milliseconds(10));
  t.RepeatStatus("b");
  t.Rest();
  ASSERT_TRUE(t.answers.contains(request));
  EXPECT_EQ(Of(t.answers.at(request), "b").outcome, ActuatorOutcome::kLost);
  const bool listed = !Degraded(t.config(), t.machine()).empty();
  EXPECT_TRUE(t.RecordOf("b").checked || listed);
}

// Ctrl-C, or `systemctl stop`, while a person tears one actuator down: it was lost.
TEST_F(OneController, ATearDownOfTheMachineIsNotLostBesideTheSwitchOfOneActuator) {
  StartUp();
  Do(event::SetStateRequested{1, kTearDown, "a"});
  ASSERT_TRUE(Of(0).command);
  Do(event::SetStateRequested{2, kTearDown, {}, AfterTearDown::kMayStart});
  Obey(0);
  for (int rounds = 0; rounds < 100; ++rounds) {
    for (ActuatorIndex i = 0; i < 2; ++i) {
      if (Of(i).command) Obey(i);
    }
    Pass(Milliseconds(100));
  }
  EXPECT_EQ(machine_.phase, Phase::kStopped);
}

// The others stayed Active for as long as c took, which has nothing to do with it.
TEST_F(Switching, TheLossOfACriticalActuatorDoesNotWaitForTheSwitchOfAnotherOne) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "a").critical = true;
  ActuatorNamed(config, "a").on_lost = "Protected";
  ActuatorNamed(config, "c").times.assign(9, std::chrono::seconds(60));
  Harness& t = In("Active", config);
  t.On("c", "LowPower").takes = std::chrono::seconds(50);
  t.RequestSwitch("LowPower", "c");
  t.RunFor(Milliseconds(10));
  t.Feed(event::Vanished{0, t.RecordOf("a").report.incarnation, true, "its process ended"});
  t.RunFor(std::chrono::seconds(5));
  EXPECT_EQ(t.StateOf("b"), "Protected");
}

// It was killed during the TearDown that a person had requested.
TEST_F(Switching, AnActuatorThatIsKilledDuringItsTearDownIsNotSwitchedOnAgain) {
  Harness& t = In("Active", Ours(2));
  t.On("b", "TearDown").hangs = true;
  const RequestId request = t.RequestSwitch("TearDown", "b");
  t.RunFor(Milliseconds(10));
  t.Crash("b");
  t.Rest();
  ASSERT_TRUE(t.answers.contains(request));
  EXPECT_THAT(t.log(), Not(Contains("b:Active")));
}

// `musher down` was requested again, of the controller that its supervisor had started after a
// crash in the TearDown: it tore nothing down, and was done.
TEST_F(Adopted, ATearDownThatIsRequestedAgainWhileItIsFinishedAwaitsWhatRuns) {
  machine_ = MakeMachine(config_);
  event::Begin begin{false, 1, {true, true}, "here"};
  begin.stop_intent = true;
  begin.restarted = true;
  begin.processes = {700, 701};
  Do(begin);
  ASSERT_TRUE(machine_.start_up.finishing);
  Do(event::SetStateRequested{1, kTearDown, {}});
  for (ActuatorIndex i = 0; i < 2; ++i) Come(i, "Active");
  for (int rounds = 0; rounds < 50; ++rounds) {
    for (ActuatorIndex i = 0; i < 2; ++i) {
      if (Of(i).command) Obey(i);
    }
    Pass(Milliseconds(100));
  }
  for (ActuatorIndex i = 0; i < 2; ++i) EXPECT_EQ(Of(i).state(), kTearDown);
}

// It was never away.
TEST_F(OneController, AnActuatorThatHasNotAnsweredTearDownWithinTheBudgetIsListed) {
  config_.shutdown_budget = Milliseconds(1000);
  for (ActuatorConfig& actuator : config_.actuators) {
    actuator.times.assign(actuator.states.size(), std::chrono::seconds(2));
  }
  StartUp();
  Do(event::SetStateRequested{1, kTearDown, {}});
  ASSERT_TRUE(Of(0).command);
  Obey(1);
  Pass(std::chrono::seconds(5));
  const auto answers = Did<action::AnswerSetState>();
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_THAT(answers[0].result.degraded, Contains("a"));
}

}  // namespace musher::testing::belief_test
