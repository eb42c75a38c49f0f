#include "musher/test/simulation/replay_check.hpp"

#include <gtest/gtest.h>

#include "musher/controller/journal/replay.hpp"

namespace musher::testing {
namespace {

using recording::ReplayLine;
using recording::ReplayReport;
using Rows = std::vector<JournalRow>;

// Encodes and decodes a row.
struct Encoded {
  JournalItem operator()(const JournalEntry& entry) const { return entry; }
  JournalItem operator()(JournalInput input) const {
    if (const auto* event = std::get_if<recording::TimedEvent>(&input.what)) {
      input.what = recording::DecodeEvent(recording::EncodeEvent(event->event, event->now)).value();
    } else if (const auto* snapshot = std::get_if<recording::SnapshotPtr>(&input.what)) {
      input.what = std::make_shared<const recording::MachineSnapshot>(
          recording::DecodeSnapshot(recording::EncodeSnapshot(**snapshot)).value());
    }
    return input;
  }
};

template <class T>
bool Holds(const JournalRow& row) {
  const auto* input = std::get_if<JournalInput>(&row.item);
  return input != nullptr && std::holds_alternative<T>(input->what);
}

ReplayReport ExpectSame(const Rows& rows, const MachineConfig& config, std::size_t from) {
  const auto replayed = recording::Replay(rows, {config, INT64_MIN, std::nullopt});
  if (!replayed) {
    ADD_FAILURE() << replayed.error().message;
    return {};
  }
  const ReplayReport& report = replayed.value();
  EXPECT_EQ(report.differences, 0U) << "from row " << from;
  for (const ReplayLine& line : report.lines) {
    if (line.mark == ReplayLine::Mark::kSame) continue;
    ADD_FAILURE() << (line.mark == ReplayLine::Mark::kNew ? "now: " : "recorded: ")
                  << line.entry.message << " (" << line.entry.id << ")\n  on " << line.input;
    break;
  }
  for (const std::string& note : report.notes) ADD_FAILURE() << note;
  return report;
}

}  // namespace

void ExpectReplaysTheSame(const simulation::SimRobot& robot) {
  Rows rows;
  for (const JournalRow& row : robot.recording()) {
    rows.push_back({row.id, std::visit(Encoded{}, row.item)});
  }
  const ReplayReport whole = ExpectSame(rows, robot.config(), 0);
  EXPECT_EQ(whole.not_replayed, 0U);
  EXPECT_EQ(whole.replayed_state, robot.machine().state);
  EXPECT_EQ(whole.recorded_state, robot.machine().state);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!Holds<recording::SnapshotPtr>(rows[i])) continue;
    Rows rest = {rows[0]};  // the config of all rows
    rest.insert(rest.end(), rows.begin() + static_cast<std::ptrdiff_t>(i), rows.end());
    const ReplayReport tail = ExpectSame(rest, robot.config(), i);
    EXPECT_EQ(tail.replayed_state, robot.machine().state);
    EXPECT_LT(tail.inputs, whole.inputs);
  }
}

}  // namespace musher::testing
