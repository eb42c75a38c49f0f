// Of a switch and its legs.

#include "musher/base/words.hpp"
#include "musher/lifecycle/record/texts.hpp"

namespace musher::texts {
namespace {

std::string CountOf(std::size_t actuators) {
  return Counted(actuators, "actuator");
}

EventName EventOf(SwitchOutcome outcome) {
  switch (outcome) {
    case SwitchOutcome::kDone:
      return EventName::kSwitchDone;
    case SwitchOutcome::kRefused:
      return EventName::kSwitchRefused;
    case SwitchOutcome::kUndone:
      return EventName::kSwitchUndone;
    case SwitchOutcome::kDoneDegraded:
      return EventName::kSwitchDoneDegraded;
    case SwitchOutcome::kSuperseded:
      break;
  }
  return EventName::kSwitchSuperseded;
}

}  // namespace

RecordText SwitchRequested(const std::string& to, const State& target) {
  return {EventName::kSwitchRequested, "switch " + to + " requested", target};
}

RecordText SwitchWaiting(const std::string& to, Duration at_most, const std::string& why) {
  return {EventName::kSwitchWaiting, "switch " + to + " waits at most " +
                                         std::to_string(ToMilliseconds(at_most)) + " ms: " + why};
}

RecordText SwitchRefused(const std::string& to, const std::string& why) {
  return {EventName::kSwitchRefused, "switch " + to + " refused: " + why};
}

RecordText SwitchStarted(CommandNumber number, const std::string& actuator, const State& from,
                         const State& target, std::size_t actuators) {
  return {EventName::kSwitchStarted, "switch " + ToString(number) + ": " +
                                         (actuator.empty() ? "" : actuator + " ") + from + " → " +
                                         target + ", " + CountOf(actuators)};
}

RecordText SwitchEnded(CommandNumber number, SwitchOutcome outcome, const std::string& reason) {
  return {EventOf(outcome), "switch " + ToString(number) + " is " +
                                std::string(OutcomeName(outcome)) +
                                (reason.empty() ? "" : ": " + reason)};
}

RecordText RollbackStarted(CommandNumber number, CommandNumber command, std::size_t actuators) {
  return {EventName::kRollbackStarted, "switch " + ToString(number) +
                                           ": rolling back with command " + ToString(command) +
                                           ", " + CountOf(actuators)};
}

RecordText AnotherFailedFirst() {
  return {EventName::kCommandSkipped, "another actuator failed first"};
}

RecordText NeededOneFailed(const std::string& needed) {
  return {EventName::kCommandSkipped, "needs " + needed + ", which failed"};
}

RecordText NoLongerAvailable() {
  return {EventName::kActuatorUnavailable, "is no longer available"};
}

RecordText RefusedByEmergencyStop() {
  return {EventName::kHeldByEmergencyStop, "is held by an emergency stop"};
}

RecordText RestartedUnchecked() {
  return {EventName::kSelfCheckMissing, "was restarted and has not passed its self-check"};
}

RecordText NoStateToGoBackTo() {
  return {EventName::kStateUnsupported, "has no state to go back to"};
}

RecordText NotDrivenBack() {
  return {EventName::kHeldByEmergencyStop, "is not driven back during an emergency stop"};
}

RecordText NoAnswerWithinBudget() {
  return {EventName::kBudgetExceeded, "no answer within the budget"};
}

RecordText BudgetUsedUp() {
  return {EventName::kBudgetExceeded, "the budget was used up"};
}

RecordText RollbackFailed(const State& target, const std::string& why) {
  return {EventName::kRollbackFailed,
          "could not be brought back to " + (target.empty() ? "rest" : target) + ": " + why};
}

RecordText StoppedWhileBusy(const State& busy_with, const State& target) {
  return {EventName::kHeldByEmergencyStop,
          "is busy with " + busy_with + ": an emergency stop has ended the switch to " + target};
}

RecordText StoppedIn(const State& state, const State& target) {
  return {EventName::kHeldByEmergencyStop,
          "is in " + state + ": an emergency stop has ended the switch to " + target};
}

}  // namespace musher::texts
