// Of an actuator: what it does by itself, and why it is degraded.

#include "musher/base/code.hpp"
#include "musher/lifecycle/machine/report.hpp"
#include "musher/lifecycle/record/texts.hpp"

namespace musher::texts {
namespace {

std::string WithinMs(Duration time) {
  return "within " + std::to_string(ToMilliseconds(time)) + " ms";
}

EventName EventOf(Health health) {
  switch (health) {
    case Health::kHung:
      return EventName::kActuatorHung;
    case Health::kCrashed:
      return EventName::kActuatorCrashed;
    case Health::kPartitioned:
      return EventName::kActuatorPartitioned;
    case Health::kStarved:
      return EventName::kActuatorStarved;
    case Health::kWell:
      break;
  }
  return EventName::kActuatorRecovered;
}

}  // namespace

RecordText ActuatorPresent(const std::string& actuator, const State& state, std::int32_t pid) {
  return {EventName::kActuatorPresent, actuator + " is present in " + state +
                                           (pid == 0 ? "" : " (pid " + std::to_string(pid) + ")")};
}

RecordText ActuatorDrifted(const std::string& actuator, const State& state,
                           const std::optional<std::string>& failure) {
  return {EventName::kActuatorDrifted,
          actuator + " has switched to " + state + " by itself" + (failure ? ": " + *failure : "")};
}

RecordText ActuatorStarved(const std::string& actuator, const std::string& how) {
  return {EventName::kActuatorStarved, actuator + " is starved: " + how};
}

RecordText ActuatorRecovered(const std::string& actuator, const std::string& how) {
  return {EventName::kActuatorRecovered, actuator + " has recovered: " + how};
}

RecordText DuplicateActuator(const std::string& actuator, std::int32_t pid, const std::string& host,
                             std::int32_t known_pid) {
  return {EventName::kDuplicateActuator, "another process publishes as " + actuator + ": process " +
                                             std::to_string(pid) + " of host " + host +
                                             "; it is ignored while process " +
                                             std::to_string(known_pid) + " answers"};
}

RecordText Degraded(const std::string& actuator, const RecordText& fault) {
  return {fault.event, actuator + " is degraded: " + fault.message};
}

RecordText DependencyDegraded(const std::string& needed, const std::string& why) {
  return {EventName::kDependencyDegraded, "needs " + needed + ", which is degraded: " + why};
}

RecordText DependencySuspended(const std::string& needed) {
  return {EventName::kDependencySuspended, "waits for " + needed + ", which is suspended"};
}

RecordText NotUp(const std::string& bound_to) {
  return {EventName::kActuatorSuspended, "suspended: " + bound_to + ", in its binds_to, is not up"};
}

RecordText SetUpFailed(std::int32_t code, const std::string& message) {
  return {EventName::kSetUpFailed,
          "SetUp failed with " + CodeText(code) + (message.empty() ? "" : ": " + message)};
}

RecordText SetUpTimeout(Duration within) {
  return {EventName::kSetUpTimeout, "was not set up " + WithinMs(within)};
}

RecordText NodeNotDiscovered(const std::string& node, Duration within, std::int32_t pid) {
  return {EventName::kNodeNotDiscovered,
          "no managed node " + node + " was discovered " + WithinMs(within) +
              (pid == 0 ? "" : ", but its program runs (process " + std::to_string(pid) + ")") +
              "; the node has another name, or no lifecycle states, or does not discover the "
              "machine: `musher check` shows why"};
}

RecordText NotAnnounced(const std::string& actuator, const std::vector<std::string>& command,
                        Duration within, std::int32_t pid) {
  std::string wrapped = R"(["musher-exec", "--")";
  for (const std::string& word : command) wrapped += ", \"" + word + "\"";
  return {EventName::kNotAnnounced,
          "its program runs (process " + std::to_string(pid) +
              ") but never announced itself as actuator " + actuator + " " + WithinMs(within) +
              "; wrap a program that is not a Musher module with musher-exec: command = " +
              wrapped + "]"};
}

RecordText NotAnnouncedBeside(const std::string& actuator, const std::string& other,
                              Duration within, std::int32_t pid) {
  return {EventName::kNotAnnounced, "was not set up " + WithinMs(within) + ": process " +
                                        std::to_string(pid) + ", which runs it and " + other +
                                        ", did not announce it; `musher restart " + actuator +
                                        "` starts both again"};
}

RecordText TornDownAlone() {
  return {EventName::kTornDownAlone, "is torn down; only a new start brings it back"};
}

RecordText SelfCheckMissing(const State& state) {
  return {EventName::kSelfCheckMissing,
          "it is in " + state + " and has not passed its self-check; run `musher set SelfCheck`"};
}

RecordText NoState(const State& state) {
  return {EventName::kStateUnsupported, "has no state '" + state + "'"};
}

RecordText HeldIn(const State& state, const State& machine) {
  return {EventName::kHeldByEmergencyStop,
          "is in " + state + ", the machine in " + machine +
              ": held by an emergency stop; after its release run `musher set " + machine + "`"};
}

RecordText EpochOutOfRange(Epoch epoch) {
  return {EventName::kEpochOutOfRange,
          "it reports epoch " + ToString(epoch) + ", which is out of range"};
}

RecordText Unhealthy(Health health, const std::string& how) {
  return {EventOf(health), std::string(HealthName(health)) + ": " + how};
}

RecordText HungIn(const State& target, Duration time) {
  return {EventName::kActuatorHung, "hung: in " + target + " for " +
                                        std::to_string(ToMilliseconds(time)) +
                                        " ms, and it cannot be queried"};
}

RecordText StillHung() {
  return {EventName::kActuatorHung, "hung: it has not recovered yet"};
}

RecordText Crashed(const std::string& how) {
  return {EventName::kActuatorCrashed, "crashed: " + how};
}

RecordText Killed() {
  return {EventName::kActuatorKilled, "it was killed"};
}

RecordText Replaced() {
  return {EventName::kActuatorReplaced, "it was restarted"};
}

RecordText PidUnknown() {
  return {EventName::kActuatorUnavailable, "its pid is unknown; it was torn down for its restart"};
}

RecordText QueryUnanswered(const State& target) {
  return {EventName::kCommandUnanswered,
          "no answer, not even to the query for the outcome of " + target};
}

RecordText Disconnected(const std::string& how) {
  return {how == kOutOfReach ? EventName::kConnectionLost : EventName::kActuatorUnavailable, how};
}

}  // namespace musher::texts
