#pragma once
// Re-runs the decision code on the recorded inputs of a journal and compares its decisions with the
// recorded ones. Pure: takes a recording, returns a report.
//
//   start ──▶ replaying ──▶ end of the session: the next start, missing rows, or the end of the
//   file
//
// A start is the beginning of a controller or a snapshot. Inputs without a start before them,
// because the journal was trimmed or is damaged, cannot be replayed and are counted.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/journal/journal_reader.hpp"
#include "musher/lifecycle/config/config.hpp"

namespace musher::recording {

struct ReplayOptions {
  // A config to use instead of the recorded one: numbers of switches and records are then not
  // compared.
  std::optional<MachineConfig> config;
  // Report only decisions of this time or epoch; earlier inputs are replayed but not reported.
  std::int64_t since_wall_ns = INT64_MIN;
  std::optional<Epoch> epoch;
};

// A decision as a journal entry.
struct ReplayLine {
  enum class Mark {
    kSame,      // recorded and replayed
    kRecorded,  // only recorded
    kNew,       // only replayed
  };

  Mark mark = Mark::kSame;
  JournalEntry entry;
  std::string input;  // the input of the decision, as JSON; empty for kSame

  friend bool operator==(const ReplayLine&, const ReplayLine&) = default;
};

struct ReplayReport {
  std::vector<ReplayLine> lines;
  bool other_config = false;     // replayed with a different config than the recorded one
  std::size_t starts = 0;        // beginnings of controllers, and snapshots after a gap
  std::size_t inputs = 0;        // replayed inputs
  std::size_t not_replayed = 0;  // inputs without a start before them
  std::size_t decisions = 0;     // replayed decisions
  std::size_t differences = 0;   // lines that are not kSame, and snapshots that differ
  State recorded_state;          // of the machine at the end
  State replayed_state;
  std::vector<std::string> notes;  // inputs that could not be replayed, and why

  bool equal() const { return differences == 0; }
};

// Fails if the config does not fit the recording, or if nothing can be replayed.
Result<ReplayReport> Replay(const std::vector<JournalRow>& rows, const ReplayOptions& options);

}  // namespace musher::recording
