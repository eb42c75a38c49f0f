// A replay is right, or it says where and why it is not.

#include "musher/controller/journal/replay.hpp"

#include <gmock/gmock.h>

#include <functional>

#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/lifecycle/record/texts.hpp"
#include "musher/simulation/robot.hpp"
#include "musher/test/controller/recorded_robot.hpp"

namespace musher::recording::replay_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Mark = ReplayLine::Mark;

std::vector<JournalRow> Rows() {
  std::vector<JournalRow> rows;
  for (JournalItem& item : RecordedLife()) {
    rows.push_back({static_cast<std::int64_t>(rows.size()) + 1, std::move(item)});
  }
  return rows;
}

ReplayReport Replayed(const std::vector<JournalRow>& rows, const ReplayOptions& options = {}) {
  auto report = Replay(rows, options);
  if (report) return std::move(report).value();
  ADD_FAILURE() << report.error().message;
  return {};
}

template <class T>
T* InputOf(JournalRow& row) {
  auto* input = std::get_if<JournalInput>(&row.item);
  return input == nullptr ? nullptr : std::get_if<T>(&input->what);
}

// The last row that holds an event of this kind.
template <class E>
std::size_t LastOf(std::vector<JournalRow>& rows) {
  for (std::size_t i = rows.size(); i-- > 0;) {
    auto* timed = InputOf<TimedEvent>(rows[i]);
    if (timed != nullptr && std::holds_alternative<E>(timed->event)) return i;
  }
  ADD_FAILURE() << "there is none";
  return 0;
}

TEST(Replay, IsTheSameAsWhatWasRecorded) {
  const ReplayReport report = Replayed(Rows());
  EXPECT_TRUE(report.equal());
  EXPECT_EQ(report.starts, 2U);
  EXPECT_GT(report.inputs, 80U);
  EXPECT_EQ(report.lines.size(), report.decisions);
  EXPECT_THAT(report.notes, IsEmpty());
}

// A controller writes the names of the modules that its program knows.
TEST(Replay, ComparesCodesWithoutTheNamesOfTheirModules) {
  simulation::SimRobot robot(1, ReadConfigText(RobotToml(), "dog.toml").config.value(),
                             [](const std::string& actuator, const State& state) {
                               simulation::Act act;
                               if (actuator == "eyes" && state == kLowPower) {
                                 act.error = {kCodeFailed, "too bright"};
                               }
                               return act;
                             });
  robot.StartController();
  robot.RunUntil([&] { return robot.machine().phase == Phase::kRunning; });
  robot.Set("LowPower");
  robot.RunFor(std::chrono::seconds(1));
  std::vector<JournalRow> rows = robot.recording();
  for (JournalRow& row : rows) {
    auto* input = std::get_if<JournalInput>(&row.item);
    auto* config = input == nullptr ? nullptr : std::get_if<ConfigText>(&input->what);
    if (config != nullptr) config->text = RobotToml();
  }
  std::size_t named = 0;
  for (JournalRow& row : rows) {
    auto* entry = std::get_if<JournalEntry>(&row.item);
    if (entry == nullptr) continue;
    named += entry->message.find("101 (Robot: Failed)") == std::string::npos ? 0 : 1;
    entry->message = WithoutModuleNames(entry->message);
  }
  EXPECT_GT(named, 0U);
  EXPECT_TRUE(Replayed(rows).equal());
}

TEST(Replay, ShowsADecisionThatIsAnotherWithItsInput) {
  auto rows = Rows();
  auto* timed = InputOf<TimedEvent>(rows[LastOf<event::SetStateRequested>(rows)]);
  std::get<event::SetStateRequested>(timed->event).target = "Protected";  // instead of Active
  const ReplayReport report = Replayed(rows);
  EXPECT_FALSE(report.equal());
  const auto first = std::find_if(report.lines.begin(), report.lines.end(),
                                  [](const auto& line) { return line.mark != Mark::kSame; });
  ASSERT_NE(first, report.lines.end());
  EXPECT_EQ(first->mark, Mark::kRecorded);
  EXPECT_EQ(first->entry.message, texts::SwitchRequested("to Active", "Active").message);
  EXPECT_THAT(first->input, HasSubstr(R"("target":"Protected")"));
}

TEST(Replay, ShowsARecordThatIsMissingAsNew) {
  auto rows = Rows();
  const std::string done = texts::SwitchEnded(3, SwitchOutcome::kDone, "").message;
  const auto gone = std::find_if(rows.begin(), rows.end(), [&](const JournalRow& row) {
    const auto* entry = std::get_if<JournalEntry>(&row.item);
    return entry != nullptr && entry->message == done;
  });
  rows.erase(gone);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].id = static_cast<std::int64_t>(i) + 1;
  const ReplayReport report = Replayed(rows);
  EXPECT_EQ(report.differences, 1U);
  const auto line = std::find_if(report.lines.begin(), report.lines.end(),
                                 [](const auto& l) { return l.mark == Mark::kNew; });
  ASSERT_NE(line, report.lines.end());
  EXPECT_EQ(line->entry.message, done);
  EXPECT_THAT(line->entry.data, HasSubstr(R"("arguments":{"number":3,"outcome":"done"})"));
}

TEST(Replay, TakesTheEndOfARecordingThatWasCutOffForRecorded) {
  auto rows = Rows();
  while (!std::holds_alternative<JournalInput>(rows.back().item)) rows.pop_back();
  EXPECT_TRUE(Replayed(rows).equal());
}

TEST(Replay, StopsAtMissingRowsAndContinuesWithTheNextSnapshot) {
  auto rows = Rows();
  rows.erase(rows.begin() + 20);
  const ReplayReport report = Replayed(rows);
  EXPECT_TRUE(report.equal());
  EXPECT_EQ(report.starts, 3U);
  EXPECT_GT(report.not_replayed, 5U);
  EXPECT_THAT(report.notes, ElementsAre("number 21 of the journal is missing"));
}

TEST(Replay, NoticesASnapshotThatIsNotTheMachine) {
  auto rows = Rows();
  bool changed = false;
  for (JournalRow& row : rows) {
    auto* snapshot = InputOf<SnapshotPtr>(row);
    if (snapshot == nullptr || changed) continue;
    MachineSnapshot other = **snapshot;
    other.machine.actuators[0].held = !other.machine.actuators[0].held;
    *snapshot = std::make_shared<const MachineSnapshot>(std::move(other));
    changed = true;
  }
  ASSERT_TRUE(changed);
  const ReplayReport report = Replayed(rows);
  EXPECT_FALSE(report.equal());
  EXPECT_THAT(report.notes,
              ElementsAre(HasSubstr("the replayed machine differs from the snapshot, number ")));
}

// The machine at the end of the recording.
Machine MachineAfter(std::vector<JournalRow>& rows, const MachineConfig& config) {
  Machine machine;
  for (JournalRow& row : rows) {
    const auto* timed = InputOf<TimedEvent>(row);
    if (timed == nullptr) continue;
    if (std::holds_alternative<event::Begin>(timed->event)) machine = MakeMachine(config);
    Step(config, machine, timed->event, timed->now);
  }
  return machine;
}

void Append(std::vector<JournalRow>& rows, JournalInput input) {
  rows.push_back({rows.empty() ? 1 : rows.back().id + 1, std::move(input)});
}

// An older version recorded fewer requesters: each of its snapshots during a TearDown differed.
TEST(Replay, DoesNotCompareARequesterThatASnapshotLacks) {
  auto rows = Rows();
  MachineSnapshot recorded;
  Time now;
  for (JournalRow& row : rows) {
    if (const auto* snapshot = InputOf<SnapshotPtr>(row)) recorded = **snapshot;
    if (const auto* timed = InputOf<TimedEvent>(row)) now = timed->now;
  }
  event::SetStateRequested down;
  down.target = kTearDown;
  down.by.name = "alice@desk";
  Append(rows, {1, TimedEvent{down, now}});
  recorded.machine = MachineAfter(rows, ReadConfigText(RobotToml(), "dog.toml").config.value());
  ASSERT_TRUE(recorded.machine.stopping && recorded.machine.standing);
  const auto notes_with = [&](const std::function<void(Machine&)>& change) {
    MachineSnapshot other = recorded;
    change(other.machine);
    auto all = rows;
    Append(all, {1, std::make_shared<const MachineSnapshot>(std::move(other))});
    return Replayed(all).notes;
  };
  EXPECT_THAT(notes_with([](Machine&) {}), IsEmpty());
  EXPECT_THAT(notes_with([](Machine& machine) {
                machine.stopping->by.name.clear();
                machine.standing->by.clear();
                machine.requested_by.clear();
              }),
              IsEmpty());
  EXPECT_THAT(notes_with([](Machine& machine) { machine.stopping->by.name = "bob@desk"; }),
              ElementsAre(HasSubstr("differs from the snapshot")));
}

TEST(Replay, RefusesAControllerThatIsNotInTheJournal) {
  ReplayOptions options;
  options.epoch = Epoch(99);
  const auto report = Replay(Rows(), options);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, "the journal has no decision of a controller with epoch 99");
}

TEST(Replay, NeedsAConfigWhenNoneIsRecorded) {
  auto rows = Rows();
  for (JournalRow& row : rows) {
    if (auto* config = InputOf<ConfigText>(row)) config->text.clear();
  }
  const auto without = Replay(rows, {});
  ASSERT_FALSE(without);
  EXPECT_EQ(without.error().message, "nothing to replay: its config is not in the journal");
  ReplayOptions options;
  options.config = ReadConfigText(RobotToml(), "dog.toml").config;
  EXPECT_TRUE(Replayed(rows, options).equal());
}

TEST(Replay, ReportsOnlyTheRequestedPartButReplaysWhatWasBefore) {
  const ReplayReport all = Replayed(Rows());
  ReplayOptions options;
  options.since_wall_ns = all.lines[all.lines.size() / 2].entry.wall_ns;
  const ReplayReport late = Replayed(Rows(), options);
  EXPECT_TRUE(late.equal());
  EXPECT_LT(late.inputs, all.inputs);
  EXPECT_GT(late.inputs, 0U);
  EXPECT_EQ(late.replayed_state, all.replayed_state);
  for (const ReplayLine& line : late.lines) {
    EXPECT_GE(line.entry.wall_ns, options.since_wall_ns);
  }
}

TEST(Replay, RefusesAnEventOfAnActuatorThatIsNotThere) {
  auto rows = Rows();
  auto* timed = InputOf<TimedEvent>(rows[LastOf<event::Replied>(rows)]);
  std::get<event::Replied>(timed->event).actuator = 99;
  const auto report = Replay(rows, {});
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message, HasSubstr("names an unknown actuator"));
}

TEST(Replay, RefusesProcessesOfMoreActuatorsThanThereAre) {
  auto rows = Rows();
  auto* timed = InputOf<TimedEvent>(rows[LastOf<event::Replied>(rows)]);
  timed->event = event::ProcessesFound{PerActuator<std::int32_t>(99, 7)};
  const auto report = Replay(rows, {});
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message, HasSubstr("names an unknown actuator"));
}

// The notes of a replay that has to start again at a snapshot, with this change in its machine.
std::vector<std::string> NotesWith(const std::function<void(Machine&)>& change) {
  auto rows = Rows();
  rows.erase(rows.begin() + 20);
  for (JournalRow& row : rows) {
    auto* snapshot = InputOf<SnapshotPtr>(row);
    if (snapshot == nullptr) continue;
    MachineSnapshot other = **snapshot;
    change(other.machine);
    *snapshot = std::make_shared<const MachineSnapshot>(std::move(other));
  }
  return Replayed(rows).notes;
}

const auto kRefused = ::testing::Contains("a snapshot is of a different config");

TEST(Replay, RejectsAnInconsistentSnapshot) {
  const auto with_switch = [](const std::function<void(Switch&)>& change) {
    return [change](Machine& machine) { change(machine.current.emplace()); };
  };
  EXPECT_THAT(NotesWith([](Machine&) {}), ::testing::Not(kRefused));
  EXPECT_THAT(NotesWith([](Machine& m) { m.actuators.resize(m.actuators.size() - 1); }), kRefused);
  EXPECT_THAT(NotesWith(with_switch([](Switch& s) { s.only = ActuatorIndex(3); })), kRefused);
  EXPECT_THAT(NotesWith(with_switch([](Switch& s) { s.legs.emplace_back().actuator = 3; })),
              kRefused);
  EXPECT_THAT(NotesWith(with_switch([](Switch& s) { s.rollback.legs.emplace_back().needs = {3}; })),
              kRefused);
  EXPECT_THAT(
      NotesWith([](Machine& machine) { machine.waiting.emplace().only = ActuatorIndex(3); }),
      kRefused);
  EXPECT_THAT(NotesWith([](Machine& machine) { machine.phase = Phase::kStopping; }), kRefused);
  EXPECT_THAT(NotesWith([](Machine& machine) {
                machine.current.reset();
                machine.stopping.emplace();
              }),
              kRefused);
}

// Its decisions would depend on a rule that is not there.
TEST(Replay, RejectsASnapshotOfARobotWithRulesThatTheConfigDoesNotHave) {
  const auto notes_with = [](const std::function<void(PolicyState&)>& change) {
    return NotesWith([change](Machine& machine) { change(machine.policy); });
  };
  EXPECT_THAT(notes_with([](PolicyState& policy) { policy.battery = 3; }), kRefused);
  EXPECT_THAT(notes_with([](PolicyState& policy) { policy.level = BatteryLevel::kLowPower; }),
              kRefused);
  EXPECT_THAT(notes_with([](PolicyState& policy) { policy.low_power = true; }), kRefused);
  EXPECT_THAT(notes_with([](PolicyState& policy) { policy.power.emplace(); }), kRefused);
}

}  // namespace musher::recording::replay_test
