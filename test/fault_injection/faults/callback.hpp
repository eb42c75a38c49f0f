#pragma once
// Faults in a module's own code, in each state.

#include <atomic>
#include <cstdint>
#include <string>

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection::callback {

// The callback of `state` does not return until the fault is cleared.
void Hangs(FaultRun& run, const std::string& state);
// The callback returns a code.
void Fails(FaultRun& run, const std::string& state);
// The work thread makes no more checkpoints.
void ThreadStopsCheckpoints(FaultRun& run);

// The expected outcome of a switch to `target` in which one actuator does not reach it.
struct SwitchExpectation {
  std::string outcome;
  std::string state;  // of the machine then
};
SwitchExpectation ExpectationForSwitch(const std::string& before, const std::string& target);
// Brings the machine to a state other than `target`.
void LeaveStateOf(FaultRun& run, const std::string& target);

// Board::hang_in or Board::fail_in.
using CallbackFault = std::atomic<std::int32_t> Board::*;
// In the SetUp of `victim` after a crash. `what` and `is`: how the controller detects it.
void InjectInSetUp(FaultRun& run, const std::string& victim, CallbackFault fault,
                   const std::string& what, const Observer::Is& is);
// In the TearDown of a module: the machine ends all the same.
void InjectInTearDown(FaultRun& run, CallbackFault fault);

}  // namespace musher::fault_injection::callback
