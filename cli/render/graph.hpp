#pragma once
// A config as a drawing: DOT (Graphviz) or Mermaid text.

#include <string>
#include <vector>

#include "musher/lifecycle/config/config.hpp"

namespace musher::cli {

// A transition between states; `both`: the reverse transition exists, too.
struct FlowTransition {
  State from;
  State to;
  bool both = false;

  friend bool operator==(const FlowTransition&, const FlowTransition&) = default;
};

// The transitions that change the machine's state, in the config's order. A self-check in the run
// phase keeps the state and is not among them.
std::vector<FlowTransition> FlowTransitions(const MachineConfig& config);

std::string FlowDot(const MachineConfig& config);
std::string FlowMermaid(const MachineConfig& config);

// Arrows lead from an actuator to those that start after it; dotted ones are `binds_to`.
std::string ActuatorsDot(const MachineConfig& config);
std::string ActuatorsMermaid(const MachineConfig& config);

}  // namespace musher::cli
