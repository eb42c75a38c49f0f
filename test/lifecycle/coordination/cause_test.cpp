// Every record names its cause: the chains end at the first cause.

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::cause_test {

using ::testing::Contains;
using ::testing::HasSubstr;

using Causes = Switching;

TEST_F(Causes, RecordsAreNumberedFromOneWithoutGaps) {
  Harness& t = In("Active");
  t.Set("LowPower");
  ASSERT_GT(t.whole_records.size(), 10U);
  for (std::size_t i = 0; i < t.whole_records.size(); ++i)
    EXPECT_EQ(t.whole_records[i].id, RecordId(i + 1));
}

TEST_F(Causes, EachRecordHasAnEvent) {
  Harness& t = In("Active");
  t.Set("LowPower");
  for (const action::Record& record : t.whole_records) {
    EXPECT_NE(record.event, EventName::kNone) << record.message;
  }
  EXPECT_EQ(t.whole_records.back().event, EventName::kSwitchDone);
}

TEST_F(Causes, TheEndOfASwitchIsCausedByTheRequest) {
  Harness& t = In("Active");
  t.Set("LowPower");
  EXPECT_THAT(Why(t.whole_records, EventName::kSwitchDone),
              Are(texts::SwitchEnded(3, SwitchOutcome::kDone, ""),
                  texts::SwitchRequested("to LowPower", "LowPower")));
  EXPECT_EQ(t.whole_records.back().state, "LowPower");
}

TEST_F(Causes, AStartIsExplainedFromItsBeginning) {
  Harness& t = In("Active");
  EXPECT_THAT(
      Why(t.whole_records, EventName::kMachineUsable),
      Are(texts::MachineUsable("Active", ""), texts::SwitchEnded(2, SwitchOutcome::kDone, ""),
          texts::SwitchEnded(1, SwitchOutcome::kDone, ""), texts::ActuatorsSetUp(3),
          texts::ControllerStarted(1, 3)));
}

TEST_F(Causes, AnUndoneSwitchIsCausedByTheFailedActuator) {
  Harness& t = In("Protected");
  t.On("b", "Active").code = 3009;
  t.Set("Active");
  t.Rest();
  const RecordText failed =
      texts::CommandEnded("b", "Active", ActuatorOutcome::kFailed, Milliseconds(10), "");
  const RecordText requested = texts::SwitchRequested("to Active", "Active");
  EXPECT_THAT(Why(t.whole_records, EventName::kSwitchUndone),
              Are(EventName::kSwitchUndone, failed, requested));
  EXPECT_THAT(Why(t.whole_records, EventName::kRollbackStarted),
              Are(EventName::kRollbackStarted, failed, requested));
}

TEST_F(Causes, ARefusalIsCausedByTheRequestAndNamesWhatIsUnderWay) {
  Harness& t = In("Active");
  t.RequestSwitch("LowPower");
  const std::string reason = t.Set("Protected").reason;
  EXPECT_THAT(reason, HasSubstr("switch 3 (to LowPower) is under way"));
  EXPECT_THAT(Why(t.whole_records, EventName::kSwitchRefused),
              Are(texts::SwitchRefused("to Protected", reason),
                  texts::SwitchRequested("to Protected", "Protected")));
}

TEST_F(Causes, SilenceIsNamedBeforeTheLoss) {
  Harness& t = In("Active");
  t.RequestSwitch("LowPower");
  t.Mute("b", true, true);
  t.Rest();
  const RecordText lost = texts::Degraded("b", texts::QueryUnanswered("LowPower"));
  EXPECT_THAT(Why(t.whole_records, lost),
              Are(lost, texts::CommandUnanswered("b", Milliseconds(100), "LowPower", true),
                  texts::SwitchRequested("to LowPower", "LowPower")));
}

TEST_F(Causes, NoQueryIsRecordedForAnActuatorThatCannotBeQueried) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "b").protocol = Protocol::kCyberdog;
  Harness& t = In("Active", config);
  t.RequestSwitch("LowPower");
  t.Mute("b", true, true);
  t.Rest();
  EXPECT_THAT(t.records,
              Contains(Is(texts::CommandUnanswered("b", Milliseconds(100), "LowPower", false))));
}

TEST_F(Causes, ASwitchThatTookOverIsNamed) {
  Harness& t = In("Active");
  t.RequestSwitch("LowPower");
  t.Set("Error");
  EXPECT_THAT(Why(t.whole_records, EventName::kSwitchSuperseded),
              Are(EventName::kSwitchSuperseded, texts::SwitchRequested("to Error", "Error")));
}

TEST_F(Causes, ATakeoverIsTheCauseOfWhatItEnds) {
  Harness& t = In("Active");
  t.RequestSwitch("LowPower");
  t.ReceiveRivalHeartbeat(99);
  EXPECT_THAT(Why(t.whole_records, EventName::kSwitchSuperseded),
              Are(EventName::kSwitchSuperseded, EventName::kControllerFenced));
}

// With processes that the controller starts.
class CausesOfProcesses : public ::testing::Test {
 protected:
  static MachineConfig Config() {
    MachineConfig config = MachineOf(2);
    for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run"};
    ActuatorConfig& a = ActuatorNamed(config, "a");
    a.critical = true;
    a.on_lost = "Protected";
    ActuatorNamed(config, "b").after = {"a"};
    return config;
  }
};

TEST_F(CausesOfProcesses, AFallbackIsExplainedDownToTheProcess) {
  Harness t(Config());
  t.Begin();
  t.Rest();
  ASSERT_EQ(t.machine().state, "Active");
  t.Crash("a");
  t.Rest();
  ASSERT_EQ(t.machine().state, "Protected");
  const auto chain = Why(t.whole_records, EventName::kSwitchDoneDegraded);
  ASSERT_THAT(chain, Are(EventName::kSwitchDoneDegraded, texts::FallbackStarted("Protected"),
                         EventName::kActuatorCrashed, EventName::kProcessExited));
  EXPECT_EQ(chain[0].state, "Protected");
  for (const std::size_t i : {2U, 3U}) EXPECT_EQ(chain[i].actuator, t.config().IndexOf("a"));
}

TEST_F(CausesOfProcesses, AnActuatorThatNeedsADegradedActuatorNamesItsCause) {
  Harness t(Config());
  t.On("a", "SetUp").code = 3001;
  t.Begin();
  t.Rest();
  const auto chain = Why(t.whole_records, EventName::kDependencyDegraded);
  ASSERT_THAT(
      chain, Are(EventName::kDependencyDegraded, EventName::kProcessExited, EventName::kSetUpFailed,
                 EventName::kProcessStarted, EventName::kControllerStarted));
  EXPECT_EQ(chain[0].actuator, t.config().IndexOf("b"));
  EXPECT_EQ(ArgumentOf(chain[0].arguments, "needed"), "a");
  for (const std::size_t i : {1U, 2U, 3U}) EXPECT_EQ(chain[i].actuator, t.config().IndexOf("a"));
}

}  // namespace musher::testing::cause_test
