#pragma once
// What goes wrong in a module's own code, in each state.

#include <string>

#include "musher/test/campaign/trial.hpp"

namespace musher::campaign::callback {

// The callback of `state` does not come back until a person looks after it.
void Hangs(Trial& trial, const std::string& state);
// It comes back with a code.
void Fails(Trial& trial, const std::string& state);
// The cycle gives no more checkpoints.
void ThreadIsSilent(Trial& trial);

// What a switch in which `victim` does not get to `target` has to end as.
struct SwitchPromise {
  std::string outcome;
  std::string state;  // of the machine then
};
SwitchPromise PromiseForSwitch(const std::string& before, const std::string& target);
// Brings the machine to a state from which `target` is another one.
void LeaveStateOf(Trial& trial, const std::string& target);

}  // namespace musher::campaign::callback
