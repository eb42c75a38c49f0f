#pragma once
// Why a request is refused: every refusal of the controller and of an actuator, with its code and
// its sentence. Nothing was done for a request that is refused. "Refusals" in
// docs/troubleshooting.md says of each one what to do, and a test provokes it; test/house holds
// both.
//
//   if (!config_.policy) return Refused<Refusal::kNoPolicy>();
//   return Refused<Refusal::kActuatorBusy>(actuator.name, record.report.target);
//
// Threads: values, from any thread.

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

#include "musher/base/code.hpp"
#include "musher/base/result.hpp"
#include "musher/base/strong_number.hpp"

namespace musher {

enum class Refusal : std::uint8_t {
  // A switch, or a plan of one.
  kNotSetUp,
  kLedByAnother,
  kLedByRival,
  kMachineTornDown,
  kBeingTornDown,
  kUnknownState,
  kUnknownActuator,
  kNoTransition,
  kFinalState,
  kStopForbidsUp,
  kStopHoldsMachine,
  kAboveCeiling,
  kRebootAhead,
  kPowerOffAhead,
  kStateUnsupported,
  kStateMissing,
  kActuatorAbsent,
  kActuatorStarting,
  kActuatorLost,
  kActuatorBusy,
  kActuatorStillBusy,
  kActuatorRestarting,
  kMoreActiveThanMachine,
  kUnchecked,
  kSuspended,
  kCriticalUnavailable,
  kCriticalTornDown,
  kCriticalUnchecked,
  kCriticalSilent,
  kSwitchUnderWay,
  kSwitchWaiting,
  kSwitchStartedFirst,
  kRequestedByAnother,
  kStopAwaitsPerson,
  kStopsUnread,
  // A request to the policy.
  kNoPolicy,
  kNoLowPowerPolicy,
  kKeepOutOfRange,
  kNothingKept,
  kKept,
  kInOta,
  kNotInOta,
  kNotInLowPower,
  // A restart.
  kNoCommand,
  kNotRestartable,
  kOnAnotherHost,
  kNoUnitOfHost,
  kProcessUnknown,
  // The release of an emergency stop.
  kStoppedMachine,
  kNoEmergencyStop,
  kStoppedAgain,
  kStopNotSeen,
  // A command to an actuator.
  kSenderUnknown,
  kEpochOutOfRange,
  kEpochOutdated,
  kEpochOfAnother,
  kNotAnnounced,
  kTakenOver,
  kOtherProcess,
  kOtherMachine,
  kUnknownKind,
  kCommandOutdated,
  kCommandReplaced,
  kCommandCancelled,
  kCommandWaitedTooLong,
  kCommandWithoutAge,
  kCommandTooOld,
  kActuatorTornDown,
  kActuatorEnds,
  kBusy,
  kNoPermitYet,
  kOnlyAtStart,
  kStopForbidsSwitchingOn,
  kCommandBeforeRelease,
  kCommandBeforeSafeState,
  kNoStateToSwitchTo,
  kControlled,
  kActuatorMayBeLate,
  // A capability.
  kNotDeclared,
  kStopForbidsCapability,
  kHeldByReleasedStop,
  kNotInThisState,
  kNotWhileSwitching,
  kBatteryTooLow,
  kBatteryUnknown,
  // A transition of a ROS 2 managed node.
  kUnknownTransition,
  kTransitionImpossible,
  kNoStateForTransition,
  kNoStateOfMachine,
  kMachineSwitching,
  kStartsByItself,
  kUnderControl,
  // A call of the controller's services.
  kNameTooLong,
  kUnknownRequest,
  kRequestOfOtherMachine,
  kMayBeLate,
  kMachineStopped,
  kRivalTakesOver,
  // The start of a controller.
  kAlreadyLed,
  kNameLedElsewhere,
  kOtherConfigRuns,
  kNameTaken,
  kNameHeld,
  kLeadsOtherMachine,
  kIdNotKnown,
};

struct RefusalForm {
  Refusal why;
  std::int32_t code;
  std::string_view sentence;  // each {place} stands for a value
};

// In the order of Refusal. A place whose name ends with '?' may be empty.
inline constexpr auto kRefusals = std::to_array<RefusalForm>({
    {Refusal::kNotSetUp, kCodeStatusError, "the machine is not set up yet"},
    {Refusal::kLedByAnother, kCodePermissionDenied, "another controller leads this machine"},
    {Refusal::kLedByRival, kCodePermissionDenied,
     "another controller, {controller}, leads this machine with epoch {epoch}"},
    {Refusal::kMachineTornDown, kCodeStateInvalid,
     "the machine is torn down; only a new start brings it back"},
    {Refusal::kBeingTornDown, kCodeStateInvalid, "the machine is being torn down"},
    {Refusal::kUnknownState, kCodeParametersInvalid,
     "unknown state '{state}';{hint?} the states are {states}"},
    {Refusal::kUnknownActuator, kCodeParametersInvalid,
     "there is no actuator '{actuator}'{known?}"},
    {Refusal::kNoTransition, kCodeStateInvalid,
     "{subject} cannot go from {state} to {target}; from here it can go to {states}"},
    {Refusal::kFinalState, kCodeStateInvalid,
     "{subject} cannot go from {state} to {target}; no state follows {state}{cure?}"},
    {Refusal::kStopForbidsUp, kCodeProtectedError,
     "an emergency stop is engaged{by?}; until it is released no switch up is possible"},
    {Refusal::kStopHoldsMachine, kCodeProtectedError,
     "an emergency stop is engaged{by?}; until it is released it holds {state}, and nothing is "
     "switched on again"},
    {Refusal::kAboveCeiling, kCodeProtectedError,
     "{battery}: the machine is limited to {state} until {condition}"},
    {Refusal::kRebootAhead, kCodeProtectedError, "the robot is about to reboot"},
    {Refusal::kPowerOffAhead, kCodeProtectedError, "the robot is about to be powered off"},
    {Refusal::kStateUnsupported, kCodeUnSupport,
     "{actuator} has no state '{state}'; it has {states}"},
    {Refusal::kStateMissing, kCodeUnSupport, "{actuator} has no state '{state}'"},
    {Refusal::kActuatorAbsent, kCodeStatusError, "{actuator} is absent"},
    {Refusal::kActuatorStarting, kCodeStatusError, "{actuator} is starting"},
    {Refusal::kActuatorLost, kCodeStatusError, "{actuator} is lost"},
    {Refusal::kActuatorBusy, kCodeTargetBusy, "{actuator} is busy with {state}"},
    {Refusal::kActuatorStillBusy, kCodeTargetBusy, "{actuator} is still busy with {state}"},
    {Refusal::kActuatorRestarting, kCodeTargetBusy, "{actuator} is being restarted"},
    {Refusal::kMoreActiveThanMachine, kCodeStateInvalid,
     "{actuator} may not be more active than the machine, which is in {state}"},
    {Refusal::kUnchecked, kCodeSelfCheckFailed,
     "{actuator} has not passed its self-check; run `musher set SelfCheck`"},
    {Refusal::kSuspended, kCodeStatusError,
     "{actuator} is suspended until the actuators in its binds_to are up"},
    {Refusal::kCriticalUnavailable, kCodeStatusError,
     "critical {actuator} is not available{cure?}"},
    {Refusal::kCriticalTornDown, kCodeStateInvalid,
     "critical {actuator} is torn down; only a new start brings it back"},
    {Refusal::kCriticalUnchecked, kCodeSelfCheckFailed,
     "critical {actuator} has not passed its self-check; run `musher set SelfCheck`"},
    {Refusal::kCriticalSilent, kCodeTargetBusy,
     "critical {actuator} has not answered {state} and cannot be queried"},
    {Refusal::kSwitchUnderWay, kCodeTargetBusy, "switch {number} ({switch}) is under way"},
    {Refusal::kSwitchWaiting, kCodeTargetBusy,
     "switch {switch} is waiting to start; retry in {left} ms"},
    {Refusal::kSwitchStartedFirst, kCodeTargetBusy, "switch {number} ({switch}) started before it"},
    {Refusal::kRequestedByAnother, kCodeStateInvalid,
     "{state} was last requested by {client}{switch?}, and a manager does not overrule that: "
     "run `musher set {target}`"},
    {Refusal::kStopAwaitsPerson, kCodeStateInvalid,
     "no state was requested since the last emergency stop, and a manager does not switch on after "
     "it: run `musher set {target}`"},
    {Refusal::kStopsUnread, kCodeStateInvalid,
     "an emergency stop may be engaged in {folder}: {why}; a manager cannot decide that: check the "
     "robot, then run `musher set {target}`"},

    {Refusal::kNoPolicy, kCodeUnSupport, "the config has no [policy]"},
    {Refusal::kNoLowPowerPolicy, kCodeUnSupport, "the config has no [policy.low_power]"},
    {Refusal::kKeepOutOfRange, kCodeParametersInvalid,
     "a keep lasts 0 to {longest} s, not {seconds} s"},
    {Refusal::kNothingKept, kCodeStateInvalid, "nothing keeps the machine in {state}"},
    {Refusal::kKept, kCodeStateInvalid,
     "the machine is kept in {state} for another {seconds} s; end it with `musher keep --end`"},
    {Refusal::kInOta, kCodeStateInvalid, "the machine is in OTA; leave OTA first"},
    {Refusal::kNotInOta, kCodeStateInvalid, "the machine is not in OTA, it is in {state}"},
    {Refusal::kNotInLowPower, kCodeStateInvalid,
     "the machine is not in LowPower, it is in {state}"},

    {Refusal::kNoCommand, kCodeUnSupport,
     "{actuator} has no command in the config: restart it where it was started"},
    {Refusal::kNotRestartable, kCodeStatusError,
     "the machine is {phase}; it cannot be restarted now"},
    {Refusal::kOnAnotherHost, kCodeUnSupport,
     "{actuator} runs on another host, {host}, where this controller cannot end processes; end "
     "process {pid} there"},
    {Refusal::kNoUnitOfHost, kCodeUnSupport,
     "{actuator} runs as process {pid}, and not as a unit of host {host} that is known here; wait "
     "if `musher history` says that the host is not reached; else another controller has started "
     "it as a child: run `kill {pid}` there, then `musher restart {actuator}`"},
    {Refusal::kProcessUnknown, kCodeUnSupport,
     "{actuator} was not started by this controller, and its process is not known: end it where "
     "it was started; a second one would run beside it"},

    {Refusal::kStoppedMachine, kCodeStateInvalid,
     "the machine is stopped; start it (`musher up`), then release the emergency stop"},
    {Refusal::kNoEmergencyStop, kCodeStateInvalid, "no emergency stop is engaged"},
    {Refusal::kStoppedAgain, kCodeProtectedError,
     "released, but an emergency stop was engaged again meanwhile{by?}; release it again once its "
     "cause is removed"},
    {Refusal::kStopNotSeen, kCodeProtectedError,
     "not released: another emergency stop has been engaged since{by?}; release it again once its "
     "cause is removed"},

    {Refusal::kSenderUnknown, kCodePermissionDenied,
     "the participant that sent the command is unknown"},
    {Refusal::kEpochOutOfRange, kCodeParametersInvalid, "epoch {epoch} is out of range"},
    {Refusal::kEpochOutdated, kCodePermissionDenied,
     "epoch {epoch} is outdated; this actuator is controlled by epoch {controller}"},
    {Refusal::kEpochOfAnother, kCodePermissionDenied,
     "epoch {epoch} belongs to another controller"},
    {Refusal::kNotAnnounced, kCodePermissionDenied,
     "no controller of epoch {epoch} has announced itself"},
    {Refusal::kTakenOver, kCodePermissionDenied, "the controller of epoch {epoch} has taken over"},
    {Refusal::kOtherProcess, kCodePermissionDenied,
     "the command is meant for another process of this name"},
    {Refusal::kOtherMachine, kCodePermissionDenied,
     "the command is of another machine, {machine}; this actuator belongs to {own machine}"},
    {Refusal::kUnknownKind, kCodeParametersInvalid, "unknown kind of command {kind}"},
    {Refusal::kCommandOutdated, kCodeStatusError,
     "command {number} is outdated; command {newer} was received already"},
    {Refusal::kCommandReplaced, kCodeTargetBusy, "replaced by command {number}"},
    {Refusal::kCommandCancelled, kCodeTimeout, "not started by its deadline; cancelled"},
    {Refusal::kCommandWaitedTooLong, kCodeTimeout, "it waited too long for an earlier command"},
    {Refusal::kCommandWithoutAge, kCodeParametersInvalid, "the command carries no valid age"},
    {Refusal::kCommandTooOld, kCodeTimeout,
     "the command is {age} ms old and was good for {budget} ms"},
    {Refusal::kActuatorTornDown, kCodeStateInvalid,
     "the actuator is torn down; only a new start brings it back"},
    {Refusal::kActuatorEnds, kCodeStateInvalid, "the actuator is torn down"},
    {Refusal::kBusy, kCodeTargetBusy, "it is busy with {state}"},
    {Refusal::kNoPermitYet, kCodeTargetBusy, "no permit to move has arrived yet"},
    {Refusal::kOnlyAtStart, kCodeStateInvalid,
     "{state} cannot be commanded: it runs only at the start of a process"},
    {Refusal::kStopForbidsSwitchingOn, kCodeProtectedError,
     "an emergency stop is engaged; until it is released nothing is switched on"},
    {Refusal::kCommandBeforeRelease, kCodeProtectedError,
     "the command was sent before an emergency stop was released; it switches nothing on"},
    {Refusal::kCommandBeforeSafeState, kCodeStatusError,
     "the command was sent before the actuator lost its controller and went to {state}; it "
     "switches nothing on"},
    {Refusal::kNoStateToSwitchTo, kCodeUnSupport,
     "{actuator} has no state '{state}' to be switched to"},
    {Refusal::kControlled, kCodePermissionDenied, "a controller has control, epoch {epoch}"},
    {Refusal::kActuatorMayBeLate, kCodeStateInvalid,
     "{actuator} could not run for {seconds} s, and the command may be as old: look at the robot, "
     "then repeat it"},

    {Refusal::kNotDeclared, kCodeStateInvalid, "{capability} is not declared for {actuator}"},
    {Refusal::kStopForbidsCapability, kCodeStateInvalid,
     "an emergency stop is engaged; until it is released {capability} does not run"},
    {Refusal::kHeldByReleasedStop, kCodeStateInvalid,
     "{actuator} is held by the emergency stop that was released; `musher set {state}` ends that"},
    {Refusal::kNotInThisState, kCodeStateInvalid,
     "{capability} runs in {states}; {actuator} is in {state}"},
    {Refusal::kNotWhileSwitching, kCodeStateInvalid,
     "{capability} runs in {states}; {actuator} is switching from {state} to {target}"},
    {Refusal::kBatteryTooLow, kCodeProtectedError,
     "{capability} needs at least {least} % of the battery; it has {percent} %"},
    {Refusal::kBatteryUnknown, kCodeProtectedError,
     "{capability} needs at least {least} % of the battery; its level is not known"},

    {Refusal::kUnknownTransition, kCodeParametersInvalid, "there is no transition '{transition}'"},
    {Refusal::kTransitionImpossible, kCodeStateInvalid, "the node is {state}"},
    {Refusal::kNoStateForTransition, kCodeUnSupport, "{actuator} has no state for this transition"},
    {Refusal::kNoStateOfMachine, kCodeUnSupport, "the machine has no state for this transition"},
    {Refusal::kMachineSwitching, kCodeTargetBusy, "switch {number} to {state} is under way"},
    {Refusal::kStartsByItself, kCodeTargetBusy,
     "the machine is starting by itself; with [ros2] start = \"manager\" it waits"},
    {Refusal::kUnderControl, kCodePermissionDenied,
     "under control of the controller of epoch {epoch}; switch the machine instead (ros2 lifecycle "
     "set /{node}), or start the actuator without a controller"},

    {Refusal::kNameTooLong, kCodeParametersInvalid,
     "a name of more than {longest} bytes is invalid"},
    {Refusal::kUnknownRequest, kCodeParametersInvalid, "unknown request '{request}'"},
    {Refusal::kRequestOfOtherMachine, kCodePermissionDenied,
     "the request is meant for another machine, {machine}; this one is {own machine}"},
    {Refusal::kMayBeLate, kCodeStateInvalid,
     "this controller could not run for {seconds} s, and the request may be as old: look at the "
     "robot, then repeat it"},
    {Refusal::kMachineStopped, kCodeStateInvalid,
     "the machine is stopped; only a new start brings it back"},
    {Refusal::kRivalTakesOver, kCodePermissionDenied,
     "another controller, {controller}, takes the machine over"},

    {Refusal::kAlreadyLed, kCodeTargetBusy,
     "another controller already leads this machine: {controller}; --takeover replaces it"},
    {Refusal::kNameLedElsewhere, kCodeTargetBusy,
     "{controller} leads a machine of this name: if that is this robot, --takeover replaces the "
     "controller; if it is another robot, give this one a `name` or a `namespace` of its own in "
     "[controller], since --takeover would make both one machine"},
    {Refusal::kOtherConfigRuns, kCodeTargetBusy,
     "{actuators} already, with a different config than {file}: `musher down --without-controller` "
     "stops what runs, `musher up --adopt` takes control of it"},
    {Refusal::kNameTaken, kCodeTargetBusy,
     "controller process {pid} already leads the actuators of {namespace}; {cure}"},
    {Refusal::kNameHeld, kCodeTargetBusy,
     "{process} holds the name of the controller of the actuators of {namespace}; if it is a "
     "controller, `musher status` shows it; --takeover starts beside it"},
    {Refusal::kLeadsOtherMachine, kCodePermissionDenied,
     "process {pid} leads another machine, {machine}, in the namespace and domain of this one, "
     "{own machine}: give one of them a `namespace` of its own in [controller], or another domain "
     "(--domain)"},
    {Refusal::kIdNotKnown, kCodePermissionDenied,
     "{controller} leads a machine of this name, which may be another robot: the id of this "
     "machine "
     "is in {folder}, which cannot be read; repair the folder, or give this machine a `name` of "
     "its "
     "own in [controller]"},
});

constexpr const RefusalForm& FormOf(Refusal why) {
  return kRefusals[static_cast<std::size_t>(why)];
}

constexpr std::size_t PlacesIn(std::string_view sentence) {
  std::size_t places = 0;
  for (const char c : sentence) places += c == '{' ? 1 : 0;
  return places;
}

// A value in a sentence.
struct RefusalValue {
  std::string text;

  RefusalValue(std::string_view words) : text(words) {}  // NOLINT(google-explicit-constructor)
  RefusalValue(std::integral auto number)                // NOLINT(google-explicit-constructor)
      : text(std::to_string(number)) {}
  template <typename Kind>
  RefusalValue(StrongNumber<Kind> number)  // NOLINT(google-explicit-constructor)
      : text(std::to_string(number.value())) {}
};

// The values go into the places of the sentence in their order, one into each.
Error MakeRefusal(std::int32_t code, std::string_view sentence,
                  std::initializer_list<RefusalValue> values);

// The code of the form, and its sentence; a number of values that does not fit the sentence does
// not compile.
template <Refusal kWhy, typename... Values>
Error Refused(const Values&... values) {
  static_assert(FormOf(kWhy).why == kWhy, "kRefusals has the order of Refusal");
  static_assert(PlacesIn(FormOf(kWhy).sentence) == sizeof...(Values),
                "one value for each place of the sentence");
  return MakeRefusal(FormOf(kWhy).code, FormOf(kWhy).sentence, {RefusalValue(values)...});
}

}  // namespace musher
