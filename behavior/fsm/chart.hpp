#pragma once
// The structure of a state machine: plain values, without the behaviour of its states.

#include <optional>
#include <string>
#include <vector>

#include "musher/behavior/fsm/ids.hpp"

namespace musher::fsm {

enum class Role {
  kNormal,
  kSafe,   // the machine goes there when it is unsafe or a state fails; at most one
  kFinal,  // the end: decides nothing more; left by Force(), Reset() and for the safe state
};

// A transition from a state to another, as the state declared it.
struct ChartTransition {
  StateId from = kNoState;
  StateId to = kNoState;
  std::string when;  // for people: "a face is seen"

  friend bool operator==(const ChartTransition&, const ChartTransition&) = default;
};

struct Chart {
  struct Node {
    std::string name;
    Role role = Role::kNormal;
    std::vector<Chart> inside;  // of a state that holds a machine: that machine; else empty

    friend bool operator==(const Node&, const Node&) = default;
  };

  std::string name;
  std::vector<Node> states;  // by id
  std::vector<ChartTransition> transitions;
  StateId start = kNoState;

  friend bool operator==(const Chart&, const Chart&) = default;
};

}  // namespace musher::fsm
