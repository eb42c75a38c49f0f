#pragma once
// What goes wrong in a module's own code, in each state.

#include <string>

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection::callback {

// The callback of `state` does not come back until a person looks after it.
void Hangs(FaultRun& run, const std::string& state);
// It comes back with a code.
void Fails(FaultRun& run, const std::string& state);
// The cycle gives no more checkpoints.
void ThreadIsSilent(FaultRun& run);

// What a switch in which `victim` does not get to `target` has to end as.
struct SwitchExpectation {
  std::string outcome;
  std::string state;  // of the machine then
};
SwitchExpectation ExpectationForSwitch(const std::string& before, const std::string& target);
// Brings the machine to a state from which `target` is another one.
void LeaveStateOf(FaultRun& run, const std::string& target);

}  // namespace musher::fault_injection::callback
