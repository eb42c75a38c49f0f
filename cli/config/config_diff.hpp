#pragma once
// What changes between two state configs, in the words of their files, and what that takes on a
// robot that runs.
//
// Pure; threads: any.

#include <set>
#include <string>
#include <vector>

#include "musher/cli/config/config_words.hpp"

namespace musher::cli {

struct ConfigChange {
  enum class Kind { kAdded, kRemoved, kChanged };

  Kind kind = Kind::kChanged;
  std::string table;   // "actuator.legs"
  std::string key;     // empty: the whole table was added or removed
  std::string before;  // of a set, its removed members; empty: none
  std::string after;   // of a set, its added members
  bool is_set = false;
  ChangeEffect effect = ChangeEffect::kTakeover;
};

struct ConfigDiff {
  std::string before;  // the file, or "the running machine"
  std::string after;
  std::vector<ConfigChange> changes;  // none: the same machine

  // What it takes on a robot that runs.
  bool needs_new_start = false;       // else: a takeover, then the restarts
  std::set<std::string> restarts;     // actuators that read a changed key when they start
  std::set<std::string> left_behind;  // removed actuators, which keep running after a takeover
};

ConfigDiff Compare(const MachineConfig& before, const MachineConfig& after);

}  // namespace musher::cli
