#include "musher/simulation/invariant.hpp"

namespace musher::simulation {

std::string_view InvariantText(Invariant invariant) {
  switch (invariant) {
    case Invariant::kNoUnrequestedActivation:
      return "no fault makes anything more active";
    case Invariant::kDoneIsComplete:
      return "after \"done\" each actuator is in the target state, or listed as degraded";
    case Invariant::kNoStaleCommand:
      return "no stale command is executed";
    case Invariant::kEmergencyStopHolds:
      return "no actuator becomes more active during an emergency stop";
    case Invariant::kOneReplyPerRequest:
      return "every request gets one reply";
    case Invariant::kMachineIsConsistent:
      return "the values of the machine agree with each other after each step";
    case Invariant::kStatesRecorded:
      return "the journal records every state of the machine";
    case Invariant::kNoPastDeadline:
      return "the next deadline is never in the past";
    case Invariant::kReachesStableState:
      return "the machine reaches a stable state after the last fault";
    case Invariant::kStatesAgree:
      return "in a stable state each live actuator is in the machine's state (after a failed "
             "start, "
             "in DeActive or less active), or listed with a reason";
    case Invariant::kTearDownEndsProcesses:
      return "TearDown ends every process within its budget";
    case Invariant::kNoRestartOnConfigError:
      return "an actuator that exits with code 2 (configuration error) is not restarted "
             "automatically";
    case Invariant::kNoDuplicateActuator:
      return "no actuator runs on two hosts";
    case Invariant::kEmergencyStopLatched:
      return "an emergency stop stays engaged until it is released, and is over afterwards";
    case Invariant::kEmergencyStopReported:
      return "an actuator that an emergency stop switched off reports it until it is on again";
    case Invariant::kReleaseIsConfirmed:
      return "after \"released\" no actuator reports a stop that was released";
    case Invariant::kNoStartAfterTearDown:
      return "after an accepted TearDown only an operator starts the machine again";
    case Invariant::kTearDownIsComplete:
      return "TearDown is \"done\" only when no running actuator is in a higher state";
    case Invariant::kNoCommandDropped:
      return "only a newer command or its timeout cancels an accepted command";
    case Invariant::kOnlyLeaderReplies:
      return "only the leading controller replies to clients";
    case Invariant::kClientGetsOutcome:
      return "a client receives an outcome, or that there is none, within a bound";
    case Invariant::kOnlyOwnProcessesSignalled:
      return "a signalled process is a child of the controller, or holds the actuator's name";
    case Invariant::kEpochRaisedOnce:
      return "a controller raises its epoch once at most, and only while it starts";
    case Invariant::kTakeoverLasts:
      return "no actuator returns to a controller that a person has replaced";
    case Invariant::kRisesAreRecorded:
      return "what rises has a record of a person or of the policy, in the controller that leads";
    case Invariant::kReachesMeantMachine:
      return "a command, a stop or a request reaches the machine that is meant, or none";
    case Invariant::kOtherMachineNeverFences:
      return "no controller releases control to a controller of another machine";
    case Invariant::kStopIsConfirmed:
      return "after exit code 0 of `musher estop` every actuator of the machine is stopped";
    case Invariant::kNoKillForTheNetwork:
      return "no controller kills a healthy process of its host for a fault of the network";
    case Invariant::kReleaseSwitchesNothingOn:
      return "the release of an emergency stop switches nothing on that was not requested since";
    case Invariant::kStopsWithoutPermit:
      return "an actuator that needs permits to move is off permit_ms after the last one";
    case Invariant::kWithinBattery:
      return "no actuator is more active than the battery permits";
    case Invariant::kNoFlapping:
      return "the battery raises only what it has lowered, beyond its hysteresis";
    case Invariant::kPolicyNeverSupersedes:
      return "the policy supersedes no switch";
    case Invariant::kPowerOffInTime:
      return "an accepted power-off happens within its time";
    case Invariant::kNotOffByOneSample:
      return "one sample of the battery powers nothing off";
    case Invariant::kRaisedAfterQuiet:
      return "the battery raises nothing within raise_after_s of a lower sample of any publisher";
    case Invariant::kNotBeforeItsTime:
      return "the policy ends what was requested no sooner than its time on its own clock";
    case Invariant::kSafeWithoutCritical:
      return "without a critical actuator the machine is in its on_lost state, or less active";
    case Invariant::kOnLostCoversLoss:
      return "on_lost names the machine's state for every actuator that is lost permanently";
    case Invariant::kRecoverable:
      return "an operator can recover the machine from every stable state";
    case Invariant::kAllAvailableAfterRecovery:
      return "after that recovery all actuators are available";
    case Invariant::kStableRules:
      return "your own rules hold in every stable state";
  }
  return {};
}

bool DependsOnConfig(Invariant invariant) {
  return invariant >= Invariant::kSafeWithoutCritical ||
         invariant == Invariant::kReachesStableState;
}

}  // namespace musher::simulation
