#pragma once
// The invariants: what must hold for every robot under every injected fault, and what a config must
// ensure.

#include <cstdint>
#include <string>
#include <string_view>

#include "musher/base/time.hpp"

namespace musher::simulation {

enum class Invariant : std::uint8_t {
  // Invariants of the middleware.
  kNoUnrequestedActivation,  // no fault makes an actuator or the machine more active
  kDoneIsComplete,           // "done": each actuator reached the target or is listed as degraded
  kNoStaleCommand,           // no command is executed late, twice, or of a superseded controller
  kEmergencyStopHolds,       // no actuator becomes more active during an emergency stop
  kOneReplyPerRequest,       // every request gets one reply
  kStatesRecorded,           // the journal records every state of the machine
  kMachineIsConsistent,      // the values of the machine agree with each other after each step
  kNoPastDeadline,           // the next deadline is never in the past
  kReachesStableState,       // after the last fault, within the bound
  kStatesAgree,              // then each live actuator is in the machine's state, or degraded
  kTearDownEndsProcesses,    // TearDown ends every process within its budget
  kNoRestartOnConfigError,   // no automatic restart after exit code 2
  kNoDuplicateActuator,      // no start while it runs on another host, where that can be known
  kEmergencyStopLatched,     // a stop stays engaged until a controller releases it, then is over
  kEmergencyStopReported,    // an actuator reports that a stop holds it, until it is on again
  kReleaseIsConfirmed,       // after "released" no actuator reports a stop that was released
  kNoStartAfterTearDown,     // after an accepted TearDown only an operator starts the machine
  kTearDownIsComplete,  // TearDown is "done" when no actuator is or has ended in a higher state
  kStaysDown,           // what a person has torn down alone is started by a person only
  kHoldStays,           // what a person has set alone is led elsewhere by a person only
  kNoCommandDropped,    // only a newer command or its timeout cancels an accepted command
  kOnlyLeaderReplies,   // only the leading controller replies to clients
  kClientGetsOutcome,   // a client gets an outcome, or that there is none, within a bound
  kOnlyOwnProcessesSignalled,  // a signalled process is a child, or holds the actuator's name
  kEpochRaisedOnce,      // a controller raises its epoch once at most, and only while it starts
  kTakeoverLasts,        // no actuator returns to a controller that a person has replaced
  kRisesAreRecorded,     // what rises has a record of a person or of the policy as its reason
  kReachesMeantMachine,  // a command, stop or request reaches the machine that is meant, or none
  kOtherMachineNeverFences,  // no controller releases control to one of another machine
  kStopIsConfirmed,      // a program that reports the machine as stopped has stopped all actuators
  kNoKillForTheNetwork,  // no controller kills a healthy process of its host
  kTornDownBeforeSignals,     // TearDown signals no process that is well before it had time for it
  kReleaseSwitchesNothingOn,  // after a release nothing rises that was not requested since the stop
  kStopsWithoutPermit,        // an actuator that needs permits is off some time after the last one
  // Invariants of the policy.
  kWithinBattery,          // no actuator is more active than the battery permits
  kNoFlapping,             // the battery raises only what it lowered, beyond its hysteresis
  kPolicyNeverSupersedes,  // the policy supersedes no switch
  kPowerOffInTime,         // an accepted power-off happens within its time
  kNotOffByOneSample,      // one sample of the battery powers nothing off
  kRaisedAfterQuiet,       // the battery raises nothing within raise_after_s of a lower sample
  kNotBeforeItsTime,       // the policy ends what a person requested no sooner than by its clock
  // That a config can violate as well.
  kSafeWithoutCritical,        // without a critical actuator the machine is in its on_lost or below
  kOnLostCoversLoss,           // on_lost says what follows when an actuator is lost permanently
  kRecoverable,                // an operator can recover the machine from every stable state
  kAllAvailableAfterRecovery,  // and then all actuators are available
  kUserRules,                  // the user's own rules hold
};
inline constexpr std::size_t kInvariants = static_cast<std::size_t>(Invariant::kUserRules) + 1;

std::string_view InvariantText(Invariant invariant);  // a sentence without its full stop
// Whether the config, rather than the middleware, can be the reason for a violation.
bool DependsOnConfig(Invariant invariant);

// An invariant that did not hold.
struct Violation {
  Invariant invariant = Invariant::kStatesAgree;
  Duration at{};     // after the robot was switched on
  std::string what;  // a sentence
};

}  // namespace musher::simulation
