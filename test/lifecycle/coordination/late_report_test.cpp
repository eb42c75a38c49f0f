// A report of an actuator that was late on its way makes the actuator's clock appear slow, and the
// commands to it older than they are.

#include "musher/lifecycle/actuator/actuator_core.hpp"
#include "musher/test/lifecycle/coordination/one_controller.hpp"

namespace musher::testing::late_report_test {

using std::chrono::seconds;
using ::testing::SizeIs;

class LateReports : public OneController {
 protected:
  // All that was received of the actuator so far was late by a second.
  void WasLate(ActuatorIndex i) { Of(i).clock_theirs -= seconds(1); }
  SwitchCommand LastTo(ActuatorIndex i) const {
    SwitchCommand last;
    for (const auto& sent : Did<action::SendSwitch>()) {
      if (sent.actuator == i) last = sent.command;
    }
    return last;
  }
  // The actuator refuses its command as too old; its reply arrives at once.
  void Refuse(ActuatorIndex i) {
    ActuatorReport report = Report(i, Of(i).state());
    report.incarnation = Of(i).report.incarnation;
    Do(event::Replied{i, Of(i).command.value().number, false, Verdict::kRefused, kCodeTimeout,
                      "it is too old", report});
  }
  void Request(const State& target) { Do(event::SetStateRequested{1, target, {}}); }
};

TEST_F(LateReports, ACommandThatOnlyAppearedTooOldIsSentAgain) {
  StartUp();
  WasLate(0);
  Request(State(kLowPower));
  const SwitchCommand first = LastTo(0);
  EXPECT_TRUE(CheckAge(first, now_)) << "the actuator refuses it";
  now_ += Milliseconds(2);
  Refuse(0);
  const SwitchCommand again = LastTo(0);
  EXPECT_EQ(again.number, first.number) << "a copy of the first one stays too old";
  EXPECT_EQ(again.target, first.target);
  EXPECT_EQ(again.budget, first.budget - Milliseconds(2)) << "the deadline is the same";
  EXPECT_FALSE(CheckAge(again, now_));
  ObeyAll();
  ASSERT_THAT(Did<action::AnswerSetState>(), SizeIs(1));
  EXPECT_TRUE(Did<action::AnswerSetState>()[0].result.done());
}

// As in a rollback that did not reach it: the machine stays where it is, and only this command
// brings the actuator down.
TEST_F(LateReports, ACommandThatBringsALateActuatorDownIsSentAgain) {
  StartUp();
  Request(State(kLowPower));
  ObeyAll();
  Do(event::Vanished{1, kFirst + 1, true, "it has exited"});
  ActuatorReport late = Report(1, State(kActive));
  late.incarnation = 99;
  late.stamp = now_ - seconds(1);
  Say(1, late);
  late.epoch = machine_.epoch;
  Do(event::Replied{1, 0, true, Verdict::kDone, kCodeOk, "", late});
  ASSERT_TRUE(Of(1).command);
  Refuse(1);
  ASSERT_TRUE(Of(1).command);
  EXPECT_FALSE(CheckAge(LastTo(1), now_));
  Obey(1);
  EXPECT_EQ(Of(1).state(), kLowPower);
  EXPECT_FALSE(Of(1).fault);
}

TEST_F(LateReports, ACommandIsRefusedWhereTheReplyShowsNoYoungerOne) {
  StartUp();
  Request(State(kLowPower));
  Refuse(0);
  EXPECT_FALSE(Of(0).command);
  Obey(1);
  EXPECT_TRUE(Of(0).fault);
}

TEST_F(LateReports, ACommandIsNotSentAgainAfterItsDeadline) {
  StartUp();
  WasLate(0);
  Request(State(kLowPower));
  const auto sent = Did<action::SendSwitch>().size();
  Pass(Milliseconds(101));  // its outcome is queried
  Refuse(0);
  EXPECT_THAT(Did<action::SendSwitch>(), SizeIs(sent));
}

TEST_F(LateReports, NothingIsSwitchedOnByACommandThatIsSentAgainDuringAnEmergencyStop) {
  StartUp();
  Request(State(kLowPower));
  ObeyAll();
  WasLate(0);
  Request(State(kActive));
  Do(event::EmergencyStopSeen{{7, "a panel", ""}});
  const auto sent = Did<action::SendSwitch>().size();
  Refuse(0);
  EXPECT_THAT(Did<action::SendSwitch>(), SizeIs(sent));
}

// It is in that state, and what the state has on is off.
TEST_F(LateReports, NoActuatorThatIsHeldIsSwitchedOnByACommandThatIsSentAgainDuringTheNextStop) {
  StartUp();
  ActuatorReport held = Report(0, State(kActive));
  held.held_by_stop = true;
  Say(0, held);
  WasLate(0);
  Request(State(kActive));
  ASSERT_TRUE(Of(0).command);
  Do(event::EmergencyStopSeen{{7, "a panel", ""}});
  const auto sent = Did<action::SendSwitch>().size();
  Refuse(0);
  EXPECT_THAT(Did<action::SendSwitch>(), SizeIs(sent));
}

}  // namespace musher::testing::late_report_test
