#pragma once
// A config as a drawing: DOT (Graphviz) or Mermaid text.

#include <string>
#include <vector>

#include "musher/lifecycle/config.hpp"

namespace musher::cli {

// A way from state to state; `both` when the way back exists too.
struct FlowWay {
  State from;
  State to;
  bool both = false;

  friend bool operator==(const FlowWay&, const FlowWay&) = default;
};

// The ways that change the machine's state, in the config's order. A self-check in the run phase
// leaves the state as it is and is none.
std::vector<FlowWay> FlowWays(const MachineConfig& config);

std::string FlowDot(const MachineConfig& config);
std::string FlowMermaid(const MachineConfig& config);

// Arrows lead from what must be up first to what comes after; dotted ones are `binds_to`.
std::string ActuatorsDot(const MachineConfig& config);
std::string ActuatorsMermaid(const MachineConfig& config);

}  // namespace musher::cli
