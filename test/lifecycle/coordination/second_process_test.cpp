// An actuator runs on two hosts, as after a start on another host while the link was cut: the
// controller commands one of the two processes, and claims nothing of the other.

#include <gmock/gmock.h>

#include <optional>
#include <string>

#include "musher/test/lifecycle/coordination/one_controller.hpp"

namespace musher::testing::second_process_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class SecondProcess : public OneController {
 protected:
  SecondProcess() { StartUp(); }

  // Of actuator 0, on host "dock".
  ActuatorReport Second(const State& state) {
    ActuatorReport report = Report(0, state);
    report.incarnation += 100;
    report.pid += 100;
    report.host = "dock";
    report.epoch = 0;
    return report;
  }
  SwitchResult Set(const State& target, const std::optional<std::string>& actuator = {}) {
    Do(event::SetStateRequested{1, target, actuator});
    ObeyAll();
    const auto answers = Did<action::AnswerSetState>();
    EXPECT_EQ(answers.size(), 1U);
    Forget();
    return answers.empty() ? SwitchResult{} : answers.front().result;
  }
};

TEST_F(SecondProcess, IsATroubleOfItsActuatorForAsLongAsItRuns) {
  EXPECT_THAT(Degraded(config_, machine_), IsEmpty());
  Say(0, Second(kActive));
  EXPECT_THAT(Degraded(config_, machine_), ElementsAre("a"));
  EXPECT_THAT(TroubleOf(Of(0))->message,
              HasSubstr("a second process of it runs and is in Active: process 800 of host dock"));
  Do(event::Vanished{0, kFirst + 100, false, kOutOfReach});
  EXPECT_THAT(Degraded(config_, machine_), IsEmpty());
}

// "set LowPower" was done while the base on the other host drove on.
TEST_F(SecondProcess, ThatIsMoreActiveIsNamedByASwitchDown) {
  Say(0, Second(kActive));
  const SwitchResult result = Set(kLowPower);
  EXPECT_EQ(result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(result.reason, HasSubstr("a: a second process of it runs and is in Active"));
  ASSERT_EQ(result.actuators.size(), 2U);
  EXPECT_EQ(result.actuators[0].outcome, ActuatorOutcome::kFailed);
  EXPECT_EQ(result.actuators[1].outcome, ActuatorOutcome::kDone);
  EXPECT_EQ(machine_.state, kLowPower);
}

TEST_F(SecondProcess, IsNamedByASwitchOfItsActuatorAlone) {
  Say(0, Second(kActive));
  EXPECT_EQ(Set(kLowPower, "a").outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_EQ(Set(kLowPower, "b").outcome, SwitchOutcome::kDone);
}

TEST_F(SecondProcess, ThatSwitchesUpIsNamedByASwitchDown) {
  ActuatorReport second = Second(kDeActive);
  second.target = kActive;
  Say(0, second);
  EXPECT_THAT(Set(kDeActive).reason, HasSubstr("a second process of it runs and is switching to"));
}

TEST_F(SecondProcess, ThatIsNoMoreActiveThanTheTargetChangesNoOutcome) {
  Say(0, Second(kLowPower));
  EXPECT_EQ(Set(kLowPower).outcome, SwitchOutcome::kDone);
}

TEST_F(SecondProcess, IsNamedByTearDown) {
  Say(0, Second(kLowPower));
  Do(event::SetStateRequested{1, kTearDown, {}});
  ObeyAll();
  Pass(config_.shutdown_budget);
  const auto answers = Did<action::AnswerSetState>();
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_EQ(answers.front().result.outcome, SwitchOutcome::kDoneDegraded);
  EXPECT_THAT(answers.front().result.reason, HasSubstr("process 800 of host dock"));
}

// The link to it was cut for a second, too short for its writer to be lost: its status does not
// come again, and it was forgotten while it was in Active.
TEST_F(SecondProcess, IsAlsoTheOneInUseBeforeThatWasOutOfReachForAMoment) {
  ActuatorReport first = Report(0, kActive);
  first.host = "board";
  first.incarnation += 200;
  first.pid += 200;
  Do(event::Vanished{0, kFirst, true, "its process 700 ended"});
  Say(0, first);
  first.epoch = machine_.epoch;
  first.number = Of(0).report.number;
  Do(event::Replied{0, first.number, true, Verdict::kDone, kCodeOk, "", first});
  ASSERT_EQ(Of(0).report.host, "board");
  Say(0, Second(kLowPower));
  Do(event::HealthChanged{0, first.incarnation, Health::kPartitioned, false, "no heartbeat"});
  EXPECT_EQ(Of(0).report.host, "dock");
  ASSERT_TRUE(Of(0).other);
  EXPECT_EQ(Of(0).other->host, "board");
  Do(event::Vanished{0, first.incarnation, false, kOutOfReach});
  EXPECT_FALSE(Of(0).other);
}

TEST_F(SecondProcess, IsTheOneInUseWhereThatIsLostForGood) {
  Say(0, Second(kActive));
  Do(event::Vanished{0, kFirst, true, "its process 700 ended"});
  EXPECT_EQ(Of(0).report.host, "dock");
  EXPECT_FALSE(Of(0).other);
}

// Its end was forgotten: the frozen process stayed in Active, and after the other host had gone the
// controller waited for it without end.
TEST_F(SecondProcess, WaitsUntilTheFrozenOneInUseIsEnded) {
  Say(0, Second(kActive));
  config_.actuators[0].command = {"a"};
  config_.actuators[0].restart.policy = RestartPolicy::kAlways;
  Do(event::ProcessStarted{0, 700, ""});
  Do(event::HealthChanged{0, kFirst, Health::kHung, true, "its process is stopped"});
  ASSERT_EQ(Did<action::TakeBacktrace>().size(), 1U);
  Say(0, Second(kActive));
  Do(event::BacktraceTaken{0, 700, ""});
  EXPECT_THAT(Did<action::SignalProcess>(), ElementsAre(action::SignalProcess{0, 700, true}));
  EXPECT_EQ(Of(0).report.host, "here");
  Do(event::ProcessEnded{0, 700, false, "killed by SIGKILL"});
  EXPECT_EQ(Of(0).report.host, "dock");
}

}  // namespace musher::testing::second_process_test
