#pragma once
// A state config as the words of its file: its tables, and the value of each key after defaults.
// Two configs with the same words are the same machine, whatever the order of their keys.
//
// Pure; threads: any.

#include <string>
#include <vector>

#include "musher/lifecycle/config/config.hpp"

namespace musher::cli {

// What a change of a key takes on a robot that runs.
enum class ChangeEffect {
  kTakeover,  // a controller that takes over with the new file
  kRestart,   // the same, then a restart of the actuator, which reads the key when it starts
  kNewStart,  // `musher down`, then `musher up`: all processes use it from their start
};

struct ConfigWord {
  std::string table;                // "actuator.legs"; "transition" for all [[transition]]
  std::string key;                  // "times (Active)"; empty: the table itself
  std::vector<std::string> values;  // one, or the members of a set
  bool is_set = false;              // their order has no meaning
  ChangeEffect effect = ChangeEffect::kTakeover;
};

// In the order of the reference. Paths and names are as the config was read.
std::vector<ConfigWord> WordsOf(const MachineConfig& config);

}  // namespace musher::cli
