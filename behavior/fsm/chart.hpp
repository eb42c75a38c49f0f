#pragma once
// A state machine as a drawing has it: plain values, without what its states do.

#include <optional>
#include <string>
#include <vector>

#include "musher/behavior/fsm/ids.hpp"

namespace musher::fsm {

enum class Role {
  kNormal,
  kSafe,   // where the machine goes when something is unsafe or fails; one of a machine
  kFinal,  // the end: decides nothing more; left by a force or a reset, and for the safe state
};

// One way from a state to another, as the state declared it.
struct Way {
  StateId from = kNoState;
  StateId to = kNoState;
  std::string when;  // for people: "a face is seen"

  friend bool operator==(const Way&, const Way&) = default;
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
  std::vector<Way> ways;
  StateId start = kNoState;

  friend bool operator==(const Chart&, const Chart&) = default;
};

}  // namespace musher::fsm
