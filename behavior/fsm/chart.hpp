#pragma once
// The structure of a state machine: plain values, without the behaviour of its states.

#include <cstdint>
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

// How a transition enters a state that holds a machine.
enum class Into : std::uint8_t {
  kStart,        // at its start state, or as the Nested::Options of the state say
  kHistory,      // where it was left; a machine inside of that state as Into::kStart
  kDeepHistory,  // where it was left, down to the innermost state
};

// A transition from a state to another, as the state declared it.
struct ChartTransition {
  StateId from = kNoState;
  StateId to = kNoState;  // kNoState: it leaves the machine
  std::string when;       // for people: "a face is seen"
  // The path of the target from the outermost machine, "SHOW/PHOTO". Empty unless the transition
  // leaves the machine or leads into a state that holds one.
  std::string target{};
  Into into = Into::kStart;

  friend bool operator==(const ChartTransition&, const ChartTransition&) = default;
};

struct Chart {
  struct Node {
    std::string name;
    Role role = Role::kNormal;
    std::vector<Chart> inside;  // the machines that the state holds, which run side by side
    std::vector<std::string> handles{};  // events that the state declared with Transitions::On()
    std::vector<std::string> defers{};   // with Transitions::Defer()

    friend bool operator==(const Node&, const Node&) = default;
  };

  std::string name;
  std::vector<Node> states;  // by id
  std::vector<ChartTransition> transitions;
  StateId start = kNoState;

  friend bool operator==(const Chart&, const Chart&) = default;
};

}  // namespace musher::fsm
