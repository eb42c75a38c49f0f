#pragma once
// The expected behaviour of a robot after a loss.

#include <set>
#include <string>

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection {

enum class Loss {
  kFailure,  // it crashed, hung, or ended with another exit code than 0
  kClean,    // it ended with exit code 0
  kForGood   // it was restarted too often
};

// The state of the machine after the loss of `victim`, and whether `victim` becomes available
// again.
struct Expectation {
  std::string state;
  bool back = true;
};
Expectation ExpectationFor(const std::string& victim, Loss loss, const std::string& state);

// Waits for the expected state, then restarts `victim` where that is left to an operator.
void AwaitExpectation(FaultRun& run, const std::string& victim, Loss loss);

// Holds for statuses in which the actuator has this health ("": in which it is lost).
Observer::Is IsKnownAs(const std::string& actuator, const std::string& health);

}  // namespace musher::fault_injection
