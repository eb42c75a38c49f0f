#pragma once
// Runs the decision code once more over what a journal recorded, and compares what it decides with
// what was decided then. Pure: a recording in, a report out.
//
//   start ──▶ replaying ──▶ the session ends: the next begins, something is missing, or the end
//
// A start is the beginning of a controller or a snapshot. What has neither before it, because the
// journal was trimmed or is damaged, cannot be replayed and is counted.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/journal_reader.hpp"
#include "musher/lifecycle/config.hpp"

namespace musher::recording {

struct ReplayOptions {
  // Instead of the recorded one: then only what it decides otherwise is of interest, numbers of
  // switches and records are not compared.
  std::optional<MachineConfig> config;
  // Of these only; all before them is replayed as well, but not told.
  std::int64_t since_wall_ns = INT64_MIN;
  std::optional<std::uint64_t> epoch;
};

// A decision, as the journal tells it.
struct ReplayLine {
  enum class Mark {
    kSame,      // made then and now
    kRecorded,  // made then, no longer made
    kNew,       // made now, but not then
  };

  Mark mark = Mark::kSame;
  JournalEntry entry;
  std::string input;  // what it was decided on, as JSON; only where the mark is not kSame

  friend bool operator==(const ReplayLine&, const ReplayLine&) = default;
};

struct ReplayReport {
  std::vector<ReplayLine> lines;
  bool other_config = false;     // it was replayed with another config than the recorded one
  std::size_t starts = 0;        // beginnings of controllers and snapshots after a gap
  std::size_t inputs = 0;        // that were replayed
  std::size_t not_replayed = 0;  // inputs without a start before them
  std::size_t decisions = 0;     // made now
  std::size_t differences = 0;   // lines that are not kSame, snapshots that are not met
  State recorded_state;          // of the machine, in the end
  State replayed_state;
  std::vector<std::string> notes;  // what could not be replayed, and why

  bool equal() const { return differences == 0; }
};

// Fails when the config does not suit the recording, or nothing can be replayed.
Result<ReplayReport> Replay(const std::vector<JournalRow>& rows, const ReplayOptions& options);

}  // namespace musher::recording
