#pragma once
// Checks that the states named by a module's own config exist.

#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/suggest.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::program {

// Fails with `code` for the first state that is neither a state of the machine nor a built-in one.
// Built-in states are accepted because a config may be shared by several machines.
inline Result<> CheckStates(const MachineConfig& machine, std::string_view key,
                            const std::vector<State>& states, std::int32_t code) {
  for (const State& state : states) {
    if (machine.HasState(state) || IsBuiltInState(state)) continue;
    return Error{code, std::string(key) + ": the machine has no state \"" + state + "\"" +
                           DidYouMean(state, machine.states, "\"\"")};
  }
  return Ok();
}

}  // namespace musher::program
