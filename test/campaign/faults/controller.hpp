#pragma once
// What happens to the controller, alone or in the middle of its work. The robot goes on without it,
// and the next one takes it over as it is.

#include "musher/test/campaign/trial.hpp"

namespace musher::campaign::controller {

// When in a switch it is killed.
enum class Moment {
  kAtRest,
  kRequested,    // the call is on its way: before the first command, or just after
  kCommandsOut,  // an actuator has begun
  kSomeReplied,  // one is done, others are not
  kSelfCheck,    // in the check of a running machine
  kRollback      // one has failed, another is being brought back
};
void KilledAt(Trial& trial, Moment moment);
// While the robot starts, and while it is torn down.
void KilledInStartUp(Trial& trial);
void KilledInStop(Trial& trial);
// Stopped and continued: for less than actuators bear to be alone, or for longer.
void FrozenShortly(Trial& trial);
void FrozenForLong(Trial& trial);
// A second controller: refused, in its place, in the place of one that is stopped, in a switch.
void SecondIsRefused(Trial& trial);
void TakenOver(Trial& trial);
void TakenOverFrozen(Trial& trial);
void TakenOverInSwitch(Trial& trial);
// Ctrl-C in the middle of a switch.
void StoppedInSwitch(Trial& trial);

}  // namespace musher::campaign::controller
