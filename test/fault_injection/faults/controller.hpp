#pragma once
// What happens to the controller, alone or in the middle of its work. The robot goes on without it,
// and the next one takes it over as it is.

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection::controller {

// When in a switch it is killed.
enum class Moment {
  kAtRest,
  kRequested,    // the call is on its way: before the first command, or just after
  kCommandsOut,  // an actuator has begun
  kSomeReplied,  // one is done, others are not
  kSelfCheck,    // in the check of a running machine
  kRollback      // one has failed, another is being brought back
};
void KilledAt(FaultRun& run, Moment moment);
// While the robot starts, and while it is torn down.
void KilledInStartUp(FaultRun& run);
void KilledInStop(FaultRun& run);
// Stopped and continued: for less than actuators bear to be alone, or for longer.
void FrozenShortly(FaultRun& run);
void FrozenForLong(FaultRun& run);
// A second controller: refused, in its place, in the place of one that is stopped, in a switch.
void SecondIsRefused(FaultRun& run);
void TakenOver(FaultRun& run);
void TakenOverFrozen(FaultRun& run);
void TakenOverInSwitch(FaultRun& run);
// Ctrl-C in the middle of a switch.
void StoppedInSwitch(FaultRun& run);

}  // namespace musher::fault_injection::controller
