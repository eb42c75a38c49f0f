#include "musher/lifecycle/machine/rule_monitor.hpp"

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::rule_monitor_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr const char* kAlways = "never machine Active while b is Active";  // violated in Active

// A rule that is checked after each step of the controller, and when a test says so.
class RulesAtRunTime : public Switching {
 protected:
  void Monitor(Harness& t, const std::string& rule) {
    UserRulesReading read = ReadUserRules(t.config(), "rules.txt", rule);
    ASSERT_THAT(read.diagnostics, IsEmpty());
    monitor_.emplace(t.config(), std::move(read.rules));
    t.after_step = [this, &t] { Check(t); };
    Check(t);
  }
  void Check(const Harness& t, Duration later = {}) {
    for (const auto& found : monitor_->Check(t.machine(), t.now() + later)) {
      found_.push_back(found.rule + ": " + found.states);
    }
  }

  std::optional<RuleMonitor> monitor_;
  std::vector<std::string> found_;
};

TEST_F(RulesAtRunTime, AreViolatedOnceTheyHaveNotHeldForASecondInAStableState) {
  Harness& t = In("Active", Ours(2));
  Monitor(t, kAlways);
  EXPECT_EQ(monitor_->next_check(), t.now() + RuleMonitor::kViolatedFor);
  Check(t, RuleMonitor::kViolatedFor - Milliseconds(1));
  EXPECT_THAT(found_, IsEmpty());
  EXPECT_THAT(monitor_->violated(), IsEmpty());
  Check(t, RuleMonitor::kViolatedFor);
  EXPECT_THAT(found_, ElementsAre("never machine Active while b is Active: the machine is in "
                                  "Active, b is in Active"));
  EXPECT_THAT(monitor_->violated(), ElementsAre(kAlways));
  EXPECT_EQ(monitor_->next_check(), std::nullopt);
}

TEST_F(RulesAtRunTime, AreReportedOnceUntilTheyHoldAgain) {
  Harness& t = In("Active", Ours(2));
  Monitor(t, kAlways);
  Check(t, std::chrono::seconds(1));
  Check(t, std::chrono::seconds(60));
  EXPECT_EQ(found_.size(), 1U);
  EXPECT_TRUE(t.Set("LowPower").done());
  t.RunFor(std::chrono::seconds(2));
  Check(t);
  EXPECT_THAT(monitor_->violated(), IsEmpty());
  EXPECT_TRUE(t.Set("Active").done());
  Check(t);
  Check(t, std::chrono::seconds(1));
  EXPECT_EQ(found_.size(), 2U);
}

// a is in LowPower before b; between them the rule does not hold.
TEST_F(RulesAtRunTime, AreNotCheckedDuringASwitch) {
  MachineConfig config = Ours(2);
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.times.assign(actuator.times.size(), std::chrono::seconds(10));
  }
  Harness& t = In("Active", config);
  Monitor(t, "never a LowPower while b is Active");
  t.On("b", "LowPower").takes = std::chrono::seconds(5);
  t.RequestSwitch("LowPower");
  t.RunFor(std::chrono::seconds(3));
  ASSERT_EQ(t.RecordOf("a").state(), "LowPower");
  ASSERT_EQ(t.RecordOf("b").state(), "Active");
  Check(t);
  t.Rest();
  Check(t, std::chrono::seconds(2));
  EXPECT_THAT(found_, IsEmpty());
}

TEST_F(RulesAtRunTime, AreNotViolatedByReportsThatArriveOneAfterTheOther) {
  Harness& t = In("Active", Ours(2));
  Monitor(t, "never b Active while a is not Active");
  Machine machine = t.machine();
  const auto found_after = [&](Duration later) {
    return monitor_->Check(machine, t.now() + later).size();
  };
  machine.actuators[0].report.state = State("LowPower");
  EXPECT_EQ(found_after(Milliseconds(0)), 0U);
  EXPECT_EQ(found_after(Milliseconds(999)), 0U);
  machine.actuators[1].report.state = State("LowPower");
  EXPECT_EQ(found_after(Milliseconds(1000)), 0U);
  EXPECT_EQ(monitor_->next_check(), std::nullopt);
  machine.actuators[1].report.state = State("Active");
  EXPECT_EQ(found_after(Milliseconds(1500)), 0U) << "its second begins again";
  EXPECT_EQ(found_after(Milliseconds(2500)), 1U);
}

// An actuator that does something by itself is in no state that lasts.
TEST_F(RulesAtRunTime, AreNotCheckedWhileACallbackRuns) {
  Harness& t = In("Active", Ours(2));
  Monitor(t, "never b Active while a is not Active");
  Machine machine = t.machine();
  machine.actuators[0].report.state = State("LowPower");
  machine.actuators[1].report.target = State("LowPower");
  EXPECT_EQ(monitor_->Check(machine, t.now()).size(), 0U);
  EXPECT_EQ(monitor_->next_check(), std::nullopt);
}

TEST_F(RulesAtRunTime, NameAnActuatorWhoseProcessHasExited) {
  MachineConfig config = Ours(2);
  ActuatorNamed(config, "b").restart.policy = RestartPolicy::kNo;
  Harness& t = In("Active", config);
  Monitor(t, "never a Active while b is exited");
  t.Crash("b");
  t.Rest();
  t.RunFor(std::chrono::seconds(1));
  Check(t);
  Check(t, std::chrono::seconds(1));
  EXPECT_THAT(found_, ElementsAre("never a Active while b is exited: a is in Active, b is exited"));
}

TEST_F(RulesAtRunTime, SayNothingOfAnActuatorThatIsOutOfReach) {
  Harness& t = In("Active", MachineOf(2));
  Monitor(t, "never a Active while b is exited\nnever a Active while b is not Active");
  const ActuatorIndex b = *t.config().IndexOf("b");
  t.Feed(event::Vanished{b, t.RecordOf("b").report.incarnation, false, "its writer is lost"});
  ASSERT_EQ(t.RecordOf("b").presence, Presence::kLost);
  Check(t);
  Check(t, std::chrono::seconds(10));
  EXPECT_THAT(found_, IsEmpty());
}

TEST_F(RulesAtRunTime, AreNotCheckedOnceTheMachineIsTornDown) {
  Harness& t = In("Active", Ours(2));
  Monitor(t, "never machine TearDown");
  t.RequestSwitch("TearDown");
  t.Rest();
  ASSERT_EQ(t.machine().phase, Phase::kStopped);
  Check(t);
  Check(t, std::chrono::seconds(10));
  EXPECT_THAT(found_, IsEmpty());
}

TEST_F(RulesAtRunTime, WithATimeAreViolatedWhenItIsOver) {
  MachineConfig config = Ours(2);
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.times.assign(actuator.times.size(), std::chrono::seconds(10));
  }
  Harness& t = In("Active", config);
  const std::string rule = "within 2 s of LowPower b in LowPower";
  Monitor(t, rule + "\nwithin 9 s of LowPower b in LowPower");
  EXPECT_EQ(monitor_->next_check(), std::nullopt);
  t.On("b", "LowPower").takes = std::chrono::seconds(5);
  const Time begun = t.now();
  t.RequestSwitch("LowPower");
  EXPECT_EQ(monitor_->next_check(), std::optional(begun + std::chrono::seconds(2)));
  ASSERT_EQ(t.now(), begun);
  Check(t, Milliseconds(1999));
  EXPECT_THAT(found_, IsEmpty());
  Check(t, Milliseconds(2000));
  EXPECT_THAT(found_, ElementsAre(rule + ": b is in Active"));
  EXPECT_THAT(monitor_->violated(), ElementsAre(rule));
  t.Rest();
  ASSERT_EQ(t.RecordOf("b").state(), "LowPower");
  EXPECT_THAT(monitor_->violated(), IsEmpty());
  EXPECT_EQ(found_.size(), 1U);
  EXPECT_EQ(monitor_->next_check(), std::nullopt);
}

TEST_F(RulesAtRunTime, WithATimeSayNothingOfAnActuatorThatIsOutOfReach) {
  Harness& t = In("Active", MachineOf(2));
  Monitor(t, "within 5 s of Active b in LowPower");
  const ActuatorIndex b = *t.config().IndexOf("b");
  t.Feed(event::Vanished{b, t.RecordOf("b").report.incarnation, false, "its writer is lost"});
  ASSERT_EQ(t.RecordOf("b").presence, Presence::kLost);
  Check(t);
  Check(t, std::chrono::seconds(5));
  Check(t, std::chrono::seconds(60));
  EXPECT_THAT(found_, IsEmpty());
  EXPECT_EQ(monitor_->next_check(), std::nullopt);
}

}  // namespace musher::testing::rule_monitor_test
