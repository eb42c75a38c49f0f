#pragma once
// Faults of the controller, idle or at work. The actuators continue without it, and the next
// controller adopts them as they are.

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection::controller {

// When in a switch the controller is killed.
enum class SwitchPhase {
  kAtRest,
  kRequested,    // the call is on its way: before the first command, or just after
  kCommandsOut,  // an actuator has begun
  kSomeReplied,  // one is done, others are not
  kSelfCheck,    // in a self-check of a running machine
  kRollback      // one has failed, another is being rolled back
};
void KilledAt(FaultRun& run, SwitchPhase phase);
// While the robot starts, and while it is torn down.
void KilledInStartUp(FaultRun& run);
void KilledInStop(FaultRun& run);
// Frozen and resumed: for less than controller_lost_ms of the actuators, or for longer.
void FrozenShortly(FaultRun& run);
void FrozenForLong(FaultRun& run);
// A second controller: refused, as a takeover, as a takeover of a frozen one, and in a switch.
void SecondIsRefused(FaultRun& run);
void TakenOver(FaultRun& run);
void TakenOverFrozen(FaultRun& run);
void TakenOverInSwitch(FaultRun& run);
// SIGTERM during a switch.
void StoppedInSwitch(FaultRun& run);

}  // namespace musher::fault_injection::controller
