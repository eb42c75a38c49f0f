// Every record names its cause: the chains end at the first cause.

#include <gmock/gmock.h>

#include <algorithm>

#include "musher/test/lifecycle/coordination/switching.hpp"

namespace musher::testing::cause_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class Causes : public Switching {
 protected:
  // The messages from the last record that begins with `message` to its first cause.
  static std::vector<std::string> Chain(const Harness& t, const std::string& message) {
    const auto last =
        std::find_if(t.whole_records.rbegin(), t.whole_records.rend(),
                     [&](const auto& record) { return record.message.starts_with(message); });
    std::vector<std::string> chain;
    if (last == t.whole_records.rend()) return chain;
    chain.push_back(last->message);
    for (RecordId cause = last->cause; cause != 0;) {
      const action::Record& record = t.whole_records[cause.value() - 1];
      chain.push_back(record.message);
      EXPECT_LT(record.cause, cause) << "a cause comes first";
      cause = record.cause;
    }
    return chain;
  }
};

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
  EXPECT_THAT(Chain(t, "switch 3 is done"),
              ElementsAre("switch 3 is done", "switch to LowPower requested"));
  EXPECT_EQ(t.whole_records.back().state, "LowPower");
}

TEST_F(Causes, AStartIsExplainedFromItsBeginning) {
  Harness& t = In("Active");
  EXPECT_THAT(Chain(t, "the machine is Active"),
              ElementsAre("the machine is Active", "switch 2 is done", "switch 1 is done",
                          "3 actuators are set up", StartsWith("controller started: epoch 1")));
}

TEST_F(Causes, AnUndoneSwitchIsCausedByTheFailedActuator) {
  Harness& t = In("Protected");
  t.On("b", "Active").code = 3009;
  t.Set("Active");
  t.Rest();
  const std::string failed = "b: Active failed after 10 ms";
  EXPECT_THAT(Chain(t, "switch 4 is undone"),
              ElementsAre(StartsWith("switch 4 is undone"), failed, "switch to Active requested"));
  EXPECT_THAT(
      Chain(t, "switch 4: rolling back"),
      ElementsAre(StartsWith("switch 4: rolling back"), failed, "switch to Active requested"));
}

TEST_F(Causes, ARefusalIsCausedByTheRequestAndNamesWhatIsUnderWay) {
  Harness& t = In("Active");
  t.RequestSwitch("LowPower");
  t.Set("Protected");
  EXPECT_THAT(Chain(t, "switch to Protected refused"),
              ElementsAre(HasSubstr("switch 3 (to LowPower) is under way"),
                          "switch to Protected requested"));
}

TEST_F(Causes, SilenceIsNamedBeforeTheLoss) {
  Harness& t = In("Active");
  t.RequestSwitch("LowPower");
  t.Mute("b", true, true);
  t.Rest();
  EXPECT_THAT(Chain(t, "b is degraded"),
              ElementsAre(StartsWith("b is degraded: no answer"),
                          StartsWith("b did not answer within 100 ms; querying"),
                          "switch to LowPower requested"));
}

TEST_F(Causes, NoQueryIsRecordedForAnActuatorThatCannotBeQueried) {
  MachineConfig config = MachineOf(3);
  ActuatorNamed(config, "b").protocol = Protocol::kCyberdog;
  Harness& t = In("Active", config);
  t.RequestSwitch("LowPower");
  t.Mute("b", true, true);
  t.Rest();
  EXPECT_THAT(t.records, Contains("b did not answer within 100 ms; its protocol has no query for "
                                  "the outcome of LowPower, so its state is unknown until it "
                                  "answers"));
}

TEST_F(Causes, ASwitchThatTookOverIsNamed) {
  Harness& t = In("Active");
  t.RequestSwitch("LowPower");
  t.Set("Error");
  EXPECT_THAT(Chain(t, "switch 3 is superseded"),
              ElementsAre(StartsWith("switch 3 is superseded"), "switch to Error requested"));
}

TEST_F(Causes, ATakeoverIsTheCauseOfWhatItEnds) {
  Harness& t = In("Active");
  t.RequestSwitch("LowPower");
  t.ReceiveRivalHeartbeat(99);
  EXPECT_THAT(Chain(t, "switch 3 is superseded"),
              ElementsAre(StartsWith("switch 3 is superseded"),
                          StartsWith("this controller (epoch 1) releases control")));
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
  const auto entered = std::find_if(t.whole_records.rbegin(), t.whole_records.rend(),
                                    [](const auto& record) { return record.state == "Protected"; });
  ASSERT_NE(entered, t.whole_records.rend());
  std::vector<std::string> chain;
  for (RecordId id = entered->id; id != 0; id = t.whole_records[id.value() - 1].cause) {
    chain.push_back(t.whole_records[id.value() - 1].message);
  }
  EXPECT_THAT(chain, ElementsAre(StartsWith("switch 3 is done-degraded"),
                                 "an actuator is lost; falling back to Protected",
                                 StartsWith("a is degraded: crashed: its process "),
                                 StartsWith("a's process ")));
}

TEST_F(CausesOfProcesses, AnActuatorThatNeedsADegradedActuatorNamesItsCause) {
  Harness t(Config());
  t.On("a", "SetUp").code = 3001;
  t.Begin();
  t.Rest();
  const auto b = std::find_if(
      t.whole_records.begin(), t.whole_records.end(),
      [](const auto& record) { return record.message.starts_with("b is degraded: needs a"); });
  ASSERT_NE(b, t.whole_records.end());
  ASSERT_NE(b->cause, RecordId(0));
  const action::Record& ended = t.whole_records[b->cause.value() - 1];
  EXPECT_THAT(ended.message, StartsWith("a's process "));
  EXPECT_THAT(t.whole_records[ended.cause.value() - 1].message, StartsWith("a is degraded"));
}

}  // namespace musher::testing::cause_test
