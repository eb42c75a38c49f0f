// Of a command to one actuator.

#include "musher/lifecycle/record/texts.hpp"

namespace musher::texts {
namespace {

std::string InMs(Duration time) {
  return std::to_string(ToMilliseconds(time)) + " ms";
}

EventName EventOf(ActuatorOutcome outcome) {
  switch (outcome) {
    case ActuatorOutcome::kDone:
    case ActuatorOutcome::kUndone:
      return EventName::kCommandDone;
    case ActuatorOutcome::kRefused:
      return EventName::kCommandRefused;
    case ActuatorOutcome::kFailed:
      return EventName::kCommandFailed;
    case ActuatorOutcome::kOverdue:
      return EventName::kCommandOverdue;
    case ActuatorOutcome::kLost:
      return EventName::kCommandLost;
    case ActuatorOutcome::kSkipped:
      return EventName::kCommandSkipped;
    case ActuatorOutcome::kUnsupported:
      break;
  }
  return EventName::kStateUnsupported;
}

}  // namespace

RecordText CommandEnded(const std::string& actuator, const State& target, ActuatorOutcome outcome,
                        Duration took, const std::string& message) {
  return {EventOf(outcome), actuator + ": " + target + " " + std::string(OutcomeName(outcome)) +
                                " after " + InMs(took) + (message.empty() ? "" : ": " + message)};
}

RecordText CommandUnanswered(const std::string& actuator, Duration waited, const State& target,
                             bool has_query) {
  const std::string next = has_query ? "; querying the outcome of " + target
                                     : "; its protocol has no query for the outcome of " + target +
                                           ", so its state is unknown until it answers";
  return {EventName::kCommandUnanswered,
          actuator + " did not answer within " + InMs(waited) + next};
}

RecordText Reported(ActuatorOutcome outcome, const std::string& message) {
  return {EventOf(outcome), message};
}

RecordText DoneDegraded(const std::string& why) {
  return {EventName::kCommandDone, "degraded: " + why};
}

RecordText StillBusy(const State& target, Duration time) {
  return {EventName::kCommandOverdue, "still busy with " + target + " after " + InMs(time)};
}

RecordText HadNotStarted(const State& target, Duration time) {
  return {EventName::kCommandOverdue, "had not started " + target + " after " + InMs(time)};
}

RecordText ContradictedBy(const State& state) {
  return {EventName::kCommandFailed, "it reports done, but its state is " + state};
}

RecordText CommandNotDone(const State& target, ActuatorOutcome outcome,
                          const std::string& message) {
  return {EventOf(outcome), target + " " + std::string(OutcomeName(outcome)) + ": " + message};
}

RecordText FailedLate(const std::string& message) {
  return {EventName::kCommandFailed, "failed after its deadline: " + message};
}

RecordText FoundBusy(const State& target, Duration time) {
  return {EventName::kCommandOverdue,
          "still busy with " + target + ", which no switch waits for, after " + InMs(time)};
}

}  // namespace musher::texts
