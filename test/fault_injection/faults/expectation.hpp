#pragma once
// What is promised of a robot of the crew after a loss.

#include <set>
#include <string>

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection {

enum class Loss {
  kFailure,  // it crashed, hung, or ended with another exit code than 0
  kClean,    // it ended with exit code 0
  kForGood   // it was restarted too often
};

// The state of the machine after the loss of `victim`, and whether it comes back.
struct Expectation {
  std::string state;
  bool back = true;
};
Expectation ExpectationFor(const std::string& victim, Loss loss, const std::string& state);

// Waits until it is kept, then mends what the promise leaves to a person.
void AwaitExpectation(FaultRun& run, const std::string& victim, Loss loss);

// Statuses in which an actuator is known to be lost, with this verdict ("": any).
Observer::Is IsKnownAs(const std::string& actuator, const std::string& health);

}  // namespace musher::fault_injection
