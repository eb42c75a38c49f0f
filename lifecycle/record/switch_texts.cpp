// Sentences about a switch and its legs.

#include "musher/base/words.hpp"
#include "musher/lifecycle/record/texts.hpp"

namespace musher::texts {
namespace {

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

RecordText SwitchRequested(const std::string& to, const State& target, const std::string& by) {
  return MakeText(EventName::kSwitchRequested,
                  by.empty() ? "switch {to} requested" : "switch {to} requested by {by}",
                  {{"to", to}, {"target", target}, {"by", by}});
}

RecordText SwitchWaiting(const std::string& to, Duration at_most, const std::string& why) {
  return MakeText(EventName::kSwitchWaiting, "switch {to} waits at most {at_most_ms} ms: {reason}",
                  {{"to", to}, {"at_most_ms", ToMilliseconds(at_most)}, {"reason", why}});
}

RecordText SwitchRefused(const std::string& to, const std::string& why) {
  return MakeText(EventName::kSwitchRefused, "switch {to} refused: {reason}",
                  {{"to", to}, {"reason", why}});
}

RecordText SwitchStarted(CommandNumber number, const std::string& actuator, const State& from,
                         const State& target, std::size_t actuators) {
  const std::string whose = actuator.empty() ? "" : "{actuator} ";
  return MakeText(EventName::kSwitchStarted,
                  "switch {number}: " + whose + "{from} → {target}, {actuators} " +
                      NounOf(actuators, "actuator"),
                  {{"number", number},
                   {"actuator", actuator},
                   {"from", from},
                   {"target", target},
                   {"actuators", actuators}});
}

RecordText SwitchEnded(CommandNumber number, SwitchOutcome outcome, const std::string& reason) {
  return MakeText(
      EventOf(outcome),
      reason.empty() ? "switch {number} is {outcome}" : "switch {number} is {outcome}: {reason}",
      {{"number", number}, {"outcome", std::string(OutcomeName(outcome))}, {"reason", reason}});
}

RecordText RollbackStarted(CommandNumber number, CommandNumber command, std::size_t actuators) {
  return MakeText(EventName::kRollbackStarted,
                  "switch {number}: rolling back with command {command}, {actuators} " +
                      NounOf(actuators, "actuator"),
                  {{"number", number}, {"command", command}, {"actuators", actuators}});
}

RecordText AnotherFailedFirst() {
  return {EventName::kCommandSkipped, "another actuator failed first"};
}

RecordText NeededOneFailed(const std::string& needed) {
  return MakeText(EventName::kCommandSkipped, "needs {needed}, which failed", {{"needed", needed}});
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
  return {EventName::kBudgetExceeded, "no time left of shutdown_budget_ms"};
}

RecordText RollbackFailed(const State& target, const std::string& why) {
  const std::string where = target.empty() ? "rest" : "{target}";
  return MakeText(EventName::kRollbackFailed,
                  "could not be brought back to " + where + ": {reason}",
                  {{"target", target}, {"reason", why}});
}

RecordText StoppedWhileBusy(const State& busy_with, const State& target) {
  return MakeText(EventName::kHeldByEmergencyStop,
                  "is busy with {busy_with}: an emergency stop has ended the switch to {target}",
                  {{"busy_with", busy_with}, {"target", target}});
}

RecordText StoppedIn(const State& state, const State& target) {
  return MakeText(EventName::kHeldByEmergencyStop,
                  "is in {state}: an emergency stop has ended the switch to {target}",
                  {{"state", state}, {"target", target}});
}

}  // namespace musher::texts
