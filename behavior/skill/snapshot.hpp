#pragma once
// The skills of a robot between two steps, by names: enough for another manager with the same
// skills to continue. Plain values; toml/snapshot_toml.hpp has them as a text.
//
// Futures are not saved: a skill that waits for one asks again when its future is not valid().

#include <cstdint>
#include <string>
#include <vector>

#include "musher/behavior/fsm/saved_part.hpp"
#include "musher/behavior/skill/run.hpp"

namespace musher::skill {

using fsm::SnapshotFault;

struct Snapshot {
  struct PastChange {
    Duration at{};
    std::uint64_t tick = 0;
    std::string from;
    std::string to;
    Cause cause = Cause::kDecided;
    std::string why;
    friend bool operator==(const PastChange&, const PastChange&) = default;
  };

  std::string skill;
  std::string state;
  bool entered = false;  // no step in this state yet
  bool paused = false;
  bool pause_requested = false;  // until it is resumed
  std::string pause_why;
  std::uint64_t ticks = 0;
  Duration time{};
  Duration elapsed{};
  int retries = 0;
  int replans = 0;
  bool cancel_requested = false;
  bool cancel_passed = false;  // to the skill
  std::string cancel_why;
  Duration cancel_at{};
  int progress = 0;
  std::string message;
  Values parameters;
  Values data;
  std::vector<PastChange> history;
  std::vector<Failure> errors;
  std::vector<fsm::SavedField> fields;  // Skill::Persist()
  std::vector<Snapshot> inside;         // of a skill that runs skills

  friend bool operator==(const Snapshot&, const Snapshot&) = default;
};

struct ManagerSnapshot {
  std::vector<Snapshot> runs;  // in the order of their starts

  friend bool operator==(const ManagerSnapshot&, const ManagerSnapshot&) = default;
};

}  // namespace musher::skill
