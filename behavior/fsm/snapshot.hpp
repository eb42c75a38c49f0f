#pragma once
// The state of a machine between two ticks, by names: enough for another machine, built alike, to
// continue identically. A value; toml/snapshot_toml.hpp has it as a text.
//
// Threads: any; one snapshot is for one thread at a time.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/behavior/fsm/machine.hpp"
#include "musher/behavior/fsm/saved_part.hpp"

namespace musher::fsm {

struct Snapshot {
  using Value = SavedValue;
  using Field = SavedField;
  // The persisted fields of a state, or of shared data.
  using Part = SavedPart;
  // A gradual transition under way, from the present state.
  struct Transition {
    std::string to;
    std::string command;  // that caused it; empty: none
    Duration elapsed{};
    Duration time{};
    friend bool operator==(const Transition&, const Transition&) = default;
  };
  struct PastChange {
    Duration at{};
    std::uint64_t tick = 0;
    std::string from;
    std::string to;
    std::string command;
    Cause cause = Cause::kDecided;
    friend bool operator==(const PastChange&, const PastChange&) = default;
  };
  struct PastFault {
    std::string state;
    Phase phase = Phase::kRun;
    Duration at{};
    std::string what;
    std::string where;
    friend bool operator==(const PastFault&, const PastFault&) = default;
  };
  struct Inside;

  std::string machine;
  bool running = false;
  bool paused = false;  // since the last tick
  Mode mode = Mode::kNormal;
  std::string state;  // empty: not running
  std::uint64_t ticks = 0;
  Duration time{};
  Duration step{};
  Duration elapsed{};
  std::string unsafe;
  std::optional<Transition> transition;
  std::vector<std::string> commands;  // queued
  std::vector<Part> command_data;     // of those that carry any, named by their place from 0
  Counts counts;
  std::optional<PastFault> fault;
  std::vector<PastChange> history;  // clear it to make the snapshot smaller
  std::vector<Part> data;           // Machine::AddData()
  std::vector<Part> states;         // the states that persist fields
  std::vector<Inside> inside;

  friend bool operator==(const Snapshot&, const Snapshot&) = default;
};

// A machine inside of a state.
struct Snapshot::Inside {
  std::string state;  // "SHOW"; "SHOW/face" of another machine in it than the first
  Snapshot machine;
  friend bool operator==(const Inside&, const Inside&) = default;
};

}  // namespace musher::fsm
