#pragma once
// What is promised of a robot of the crew after a loss.

#include <set>
#include <string>

#include "musher/test/campaign/trial.hpp"

namespace musher::campaign {

enum class Loss {
  kFailure,  // it crashed, hung, or ended with another exit code than 0
  kClean,    // it ended with exit code 0
  kForGood   // it was restarted too often
};

// The state of the machine after the loss of `victim`, and whether it comes back.
struct Promise {
  std::string state;
  bool back = true;
};
Promise PromiseFor(const std::string& victim, Loss loss, const std::string& state);

// Waits until it is kept, then mends what the promise leaves to a person.
void AwaitPromise(Trial& trial, const std::string& victim, Loss loss);

// Statuses in which an actuator is known to be lost, with this verdict ("": any).
Observer::Is IsKnownAs(const std::string& actuator, const std::string& health);

}  // namespace musher::campaign
