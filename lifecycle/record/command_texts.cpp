// Sentences about a command to one actuator.

#include "musher/lifecycle/record/texts.hpp"

namespace musher::texts {
namespace {

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
  return MakeText(EventOf(outcome),
                  std::string("{actuator}: {target} {outcome} after {took_ms} ms") +
                      (message.empty() ? "" : ": {message}"),
                  {{"actuator", actuator},
                   {"target", target},
                   {"outcome", std::string(OutcomeName(outcome))},
                   {"took_ms", ToMilliseconds(took)},
                   {"message", message}});
}

RecordText CommandUnanswered(const std::string& actuator, Duration waited, const State& target,
                             bool has_query) {
  const std::string next = has_query ? "; querying the outcome of {target}"
                                     : "; its protocol has no query for the outcome of {target}, "
                                       "so its state is unknown until it answers";
  return MakeText(
      EventName::kCommandUnanswered, "{actuator} did not answer within {within_ms} ms" + next,
      {{"actuator", actuator}, {"within_ms", ToMilliseconds(waited)}, {"target", target}});
}

RecordText Reported(ActuatorOutcome outcome, const std::string& message) {
  return MakeText(EventOf(outcome), "{message}", {{"message", message}});
}

RecordText DoneDegraded(const std::string& why) {
  return MakeText(EventName::kCommandDone, "degraded: {reason}", {{"reason", why}});
}

RecordText StillBusy(const State& target, Duration time) {
  return MakeText(EventName::kCommandOverdue, "still busy with {target} after {after_ms} ms",
                  {{"target", target}, {"after_ms", ToMilliseconds(time)}});
}

RecordText HadNotStarted(const State& target, Duration time) {
  return MakeText(EventName::kCommandOverdue, "had not started {target} after {after_ms} ms",
                  {{"target", target}, {"after_ms", ToMilliseconds(time)}});
}

RecordText ContradictedBy(const State& state) {
  return MakeText(EventName::kCommandFailed, "it reports done, but its state is {state}",
                  {{"state", state}});
}

RecordText CommandNotDone(const State& target, ActuatorOutcome outcome,
                          const std::string& message) {
  return MakeText(
      EventOf(outcome), "{target} {outcome}: {message}",
      {{"target", target}, {"outcome", std::string(OutcomeName(outcome))}, {"message", message}});
}

RecordText FailedLate(const std::string& message) {
  return MakeText(EventName::kCommandFailed, "failed after its deadline: {message}",
                  {{"message", message}});
}

RecordText FoundBusy(const State& target, Duration time) {
  return MakeText(EventName::kCommandOverdue,
                  "still busy with {target}, which no switch waits for, after {after_ms} ms",
                  {{"target", target}, {"after_ms", ToMilliseconds(time)}});
}

}  // namespace musher::texts
