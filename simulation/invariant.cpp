#include "musher/simulation/invariant.hpp"

#include <array>

namespace musher::simulation {

namespace {

struct Row {
  Invariant invariant;
  std::string_view text;
};

constexpr std::array<Row, kInvariants> kTexts = {{
    {Invariant::kNoUnrequestedActivation, "no fault makes anything more active"},
    {Invariant::kDoneIsComplete,
     "after \"done\" each actuator is in the target state, or listed as degraded"},
    {Invariant::kNoStaleCommand, "no stale command is executed"},
    {Invariant::kEmergencyStopHolds, "no actuator becomes more active during an emergency stop"},
    {Invariant::kOneReplyPerRequest, "every request gets one reply"},
    {Invariant::kStatesRecorded, "the journal records every state of the machine"},
    {Invariant::kMachineIsConsistent,
     "the values of the machine agree with each other after each step"},
    {Invariant::kNoPastDeadline, "the next deadline is never in the past"},
    {Invariant::kReachesStableState, "the machine reaches a stable state after the last fault"},
    {Invariant::kStatesAgree,
     "in a stable state each live actuator is in the machine's state (after a failed start, in "
     "DeActive or less active), or listed with a reason"},
    {Invariant::kTearDownEndsProcesses, "TearDown ends every process within its budget"},
    {Invariant::kNoRestartOnConfigError,
     "an actuator that exits with code 2 (configuration error) is not restarted automatically"},
    {Invariant::kNoDuplicateActuator, "no actuator runs on two hosts"},
    {Invariant::kEmergencyStopLatched,
     "an emergency stop stays engaged until it is released, and is over afterwards"},
    {Invariant::kEmergencyStopReported,
     "an actuator that an emergency stop switched off reports it until it is on again"},
    {Invariant::kReleaseIsConfirmed,
     "after \"released\" no actuator reports a stop that was released"},
    {Invariant::kNoStartAfterTearDown,
     "after an accepted TearDown only an operator starts the machine again"},
    {Invariant::kTearDownIsComplete,
     "TearDown is \"done\" only when no actuator runs, or has ended, in a higher state"},
    {Invariant::kStaysDown,
     "an actuator that a person has torn down alone is started by a person only"},
    {Invariant::kHoldStays, "an actuator that a person has set alone is raised by a person only"},
    {Invariant::kNoCommandDropped,
     "only a newer command or its timeout cancels an accepted command"},
    {Invariant::kOnlyLeaderReplies, "only the leading controller replies to clients"},
    {Invariant::kClientGetsOutcome,
     "a client receives an outcome, or that there is none, within a bound"},
    {Invariant::kOnlyOwnProcessesSignalled,
     "a signalled process is a child of the controller, or holds the actuator's name"},
    {Invariant::kEpochRaisedOnce,
     "a controller raises its epoch once at most, and only while it starts"},
    {Invariant::kTakeoverLasts, "no actuator returns to a controller that a person has replaced"},
    {Invariant::kRisesAreRecorded,
     "what rises has a record of a person or of the policy, in the controller that leads"},
    {Invariant::kReachesMeantMachine,
     "a command, a stop or a request reaches the machine that is meant, or none"},
    {Invariant::kOtherMachineNeverFences,
     "no controller releases control to a controller of another machine"},
    {Invariant::kStopIsConfirmed,
     "after exit code 0 of `musher estop` every actuator of the machine is stopped"},
    {Invariant::kNoKillForTheNetwork,
     "no controller kills a healthy process of its host for a fault of the network"},
    {Invariant::kTornDownBeforeSignals,
     "TearDown signals no process that is well before that had time for its own TearDown"},
    {Invariant::kReleaseSwitchesNothingOn,
     "the release of an emergency stop switches nothing on that was not requested since"},
    {Invariant::kStopsWithoutPermit,
     "an actuator that needs permits to move is off permit_ms after the last one"},
    {Invariant::kWithinBattery, "no actuator is more active than the battery permits"},
    {Invariant::kNoFlapping, "the battery raises only what it has lowered, beyond its hysteresis"},
    {Invariant::kPolicyNeverSupersedes, "the policy supersedes no switch"},
    {Invariant::kPowerOffInTime, "an accepted power-off happens within its time"},
    {Invariant::kNotOffByOneSample, "one sample of the battery powers nothing off"},
    {Invariant::kRaisedAfterQuiet,
     "the battery raises nothing within raise_after_s of a lower sample of any publisher"},
    {Invariant::kNotBeforeItsTime,
     "the policy ends what was requested no sooner than its time on its own clock"},
    {Invariant::kSafeWithoutCritical,
     "without a critical actuator the machine is in its on_lost state, or less active"},
    {Invariant::kOnLostCoversLoss,
     "on_lost names the machine's state for every actuator that is lost permanently"},
    {Invariant::kRecoverable, "an operator can recover the machine from every stable state"},
    {Invariant::kAllAvailableAfterRecovery, "after that recovery all actuators are available"},
    {Invariant::kUserRules, "your own rules hold"},
}};

constexpr bool IsComplete() {
  std::size_t next = 0;
  for (const Row& row : kTexts) {
    if (row.invariant != static_cast<Invariant>(next++) || row.text.empty()) return false;
  }
  return true;
}
static_assert(IsComplete());

}  // namespace

std::string_view InvariantText(Invariant invariant) {
  return kTexts[static_cast<std::size_t>(invariant)].text;
}

bool DependsOnConfig(Invariant invariant) {
  return invariant >= Invariant::kSafeWithoutCritical ||
         invariant == Invariant::kReachesStableState;
}

}  // namespace musher::simulation
