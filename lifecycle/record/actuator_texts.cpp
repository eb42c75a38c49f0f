// Sentences about an actuator: what it does by itself, and why it is degraded.

#include "musher/base/code.hpp"
#include "musher/lifecycle/machine/report.hpp"
#include "musher/lifecycle/record/texts.hpp"

namespace musher::texts {
namespace {

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

// Why a program that runs has not announced its actuator, and what to do.
std::string WhyNotAnnounced(StartProgress progress) {
  const std::string more_time = "give its SetUp more time in `times`";
  const std::string wrap = "wrap it with musher-exec: command = {command}";
  switch (progress) {
    case StartProgress::kNamed:
      return "it holds the name of the actuator, so it is still starting: " + more_time;
    case StartProgress::kBusy:
      return "it is busy, so it is probably still starting: " + more_time +
             "; if it is not a Musher module, " + wrap;
    case StartProgress::kIdle:
      return "it is idle and does not hold the name of the actuator, so it is not a Musher module, "
             "or one of another name: " +
             wrap;
    case StartProgress::kUnknown:
      break;
  }
  return "if it is still starting, " + more_time + "; if it is not a Musher module, " + wrap;
}

}  // namespace

RecordText ActuatorPresent(const std::string& actuator, const State& state, std::int32_t pid,
                           const State& target) {
  return MakeText(
      EventName::kActuatorPresent,
      std::string("{actuator} is present in {state}") +
          (target.empty() ? "" : ", on its way to {target}") + (pid == 0 ? "" : " (pid {pid})"),
      {{"actuator", actuator}, {"state", state}, {"target", target}, {"pid", Known(pid)}});
}

RecordText ActuatorDrifted(const std::string& actuator, const State& state,
                           const std::optional<std::string>& failure) {
  return MakeText(
      EventName::kActuatorDrifted,
      std::string("{actuator} has switched to {state} by itself") + (failure ? ": {failure}" : ""),
      {{"actuator", actuator}, {"state", state}, {"failure", failure.value_or("")}});
}

RecordText ActuatorStarved(const std::string& actuator, const std::string& how) {
  return MakeText(EventName::kActuatorStarved, "{actuator} is starved: {how}",
                  {{"actuator", actuator}, {"how", how}});
}

RecordText ActuatorRecovered(const std::string& actuator, const std::string& how) {
  return MakeText(EventName::kActuatorRecovered, "{actuator} has recovered: {how}",
                  {{"actuator", actuator}, {"how", how}});
}

RecordText TwoNodes(const std::string& which) {
  return MakeText(EventName::kDuplicateActuator, "{nodes}", {{"nodes", which}});
}

RecordText DuplicateActuator(const std::string& actuator, std::int32_t pid, const std::string& host,
                             std::int32_t known_pid) {
  const std::string known = known_pid == 0 ? "the known process" : "process {known_pid}";
  return MakeText(
      EventName::kDuplicateActuator,
      "another process publishes as {actuator}: process {pid} of host {host}; it is ignored "
      "while " +
          known + " answers",
      {{"actuator", actuator}, {"pid", pid}, {"host", host}, {"known_pid", Known(known_pid)}});
}

RecordText ConfigDiffers(const std::string& actuator, const std::string& hash,
                         const std::string& file, const std::string& own_hash) {
  return MakeText(
      EventName::kConfigDiffers,
      "{actuator} is using a different config ({hash}) than {config} ({own_hash}); if a "
      "change concerns it, `musher restart {actuator}` starts it with this one",
      {{"actuator", actuator}, {"hash", hash}, {"config", file}, {"own_hash", own_hash}});
}

RecordText Degraded(const std::string& actuator, const RecordText& fault) {
  RecordText text = MakeText(fault.event, "{actuator} is degraded: ", {{"actuator", actuator}});
  text.message += fault.message;
  for (const Argument& argument : fault.arguments) {
    if (argument.name != "actuator") text.arguments.push_back(argument);
  }
  return text;
}

RecordText DependencyDegraded(const std::string& needed, const std::string& why) {
  return MakeText(EventName::kDependencyDegraded, "needs {needed}, which is degraded: {reason}",
                  {{"needed", needed}, {"reason", why}});
}

RecordText DependencySuspended(const std::string& needed) {
  return MakeText(EventName::kDependencySuspended, "waits for {needed}, which is suspended",
                  {{"needed", needed}});
}

RecordText NotUp(const std::string& bound_to) {
  return MakeText(EventName::kActuatorSuspended, "suspended: {needed}, in its binds_to, is not up",
                  {{"needed", bound_to}});
}

RecordText SetUpFailed(std::int32_t code, const std::string& message) {
  return MakeText(EventName::kSetUpFailed,
                  "SetUp failed with " + CodeText(code) + (message.empty() ? "" : ": {message}"),
                  {{"code", code}, {"message", message}});
}

RecordText SetUpTimeout(Duration within) {
  return MakeText(EventName::kSetUpTimeout, "was not set up within {within_ms} ms",
                  {{"within_ms", ToMilliseconds(within)}});
}

RecordText NodeNotDiscovered(const std::string& node, Duration within, std::int32_t pid) {
  const std::string runs = pid == 0 ? "" : ", but its program runs (process {pid})";
  return MakeText(EventName::kNodeNotDiscovered,
                  "no managed node {node} was discovered within {within_ms} ms" + runs +
                      "; the node has another name, or no lifecycle states, or does not discover "
                      "the machine: `musher check` shows why",
                  {{"node", node}, {"within_ms", ToMilliseconds(within)}, {"pid", Known(pid)}});
}

RecordText NotAnnounced(const std::string& actuator, const std::vector<std::string>& command,
                        Duration within, std::int32_t pid, StartProgress progress) {
  std::string wrapped = R"(["musher-exec", "--")";
  for (const std::string& word : command) wrapped += ", \"" + word + "\"";
  return MakeText(EventName::kNotAnnounced,
                  "its program runs (process {pid}) but did not announce itself as actuator "
                  "{actuator} within {within_ms} ms; " +
                      WhyNotAnnounced(progress),
                  {{"pid", pid},
                   {"actuator", actuator},
                   {"within_ms", ToMilliseconds(within)},
                   {"command", wrapped + "]"}});
}

RecordText NotAnnouncedBeside(const std::string& actuator, const std::string& other,
                              Duration within, std::int32_t pid) {
  return MakeText(EventName::kNotAnnounced,
                  "was not set up within {within_ms} ms: process {pid}, which runs it and {other}, "
                  "did not announce it; `musher restart {actuator}` starts both again",
                  {{"within_ms", ToMilliseconds(within)},
                   {"pid", pid},
                   {"other", other},
                   {"actuator", actuator}});
}

RecordText StartedBeside(const std::string& other) {
  return MakeText(EventName::kTornDownAlone,
                  "was torn down alone, and its process was started again for {other}; it stays in "
                  "SetUp until a person sets it to SelfCheck",
                  {{"other", other}});
}

RecordText TornDownAlone() {
  return {EventName::kTornDownAlone, "is torn down; only a new start brings it back"};
}

RecordText SelfCheckMissing(const State& state) {
  return MakeText(EventName::kSelfCheckMissing,
                  "it is in {state} and has not passed its self-check; run `musher set SelfCheck`",
                  {{"state", state}});
}

RecordText NoState(const State& state) {
  return MakeText(EventName::kStateUnsupported, "has no state '{state}'", {{"state", state}});
}

RecordText HeldIn(const State& state, const State& machine) {
  return MakeText(EventName::kHeldByEmergencyStop,
                  "is in {state}, the machine in {machine}: held by an emergency stop; after its "
                  "release run `musher set {machine}`",
                  {{"state", state}, {"machine", machine}});
}

RecordText FoundBelow(const State& state, const State& machine) {
  return MakeText(EventName::kFoundBelow,
                  "was found in {state} after the machine went on in {machine}; run `musher set "
                  "{machine}` if it may rise",
                  {{"state", state}, {"machine", machine}});
}

RecordText EpochOutOfRange(Epoch epoch) {
  return MakeText(EventName::kEpochOutOfRange, "it reports epoch {epoch}, which is out of range",
                  {{"epoch", epoch}});
}

RecordText ControlledByAnother(Epoch epoch) {
  return MakeText(EventName::kControlledByAnother,
                  "another controller has taken control of it with epoch {epoch}; `musher up "
                  "--takeover` takes it back",
                  {{"epoch", epoch}});
}

RecordText Unhealthy(Health health, const std::string& how) {
  return MakeText(EventOf(health), "{health}: {how}",
                  {{"health", std::string(HealthName(health))}, {"how", how}});
}

RecordText HungIn(const State& target, Duration time) {
  return MakeText(EventName::kActuatorHung,
                  "hung: in {target} for {after_ms} ms, and it cannot be queried",
                  {{"target", target}, {"after_ms", ToMilliseconds(time)}});
}

RecordText StillHung() {
  return {EventName::kActuatorHung, "hung: it has not recovered yet"};
}

RecordText Crashed(const std::string& how) {
  return MakeText(EventName::kActuatorCrashed, "crashed: {how}", {{"how", how}});
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
  return MakeText(EventName::kCommandUnanswered,
                  "no answer, not even to the query for the outcome of {target}",
                  {{"target", target}});
}

RecordText Disconnected(const std::string& how) {
  return MakeText(how == kOutOfReach ? EventName::kConnectionLost : EventName::kActuatorUnavailable,
                  "{how}", {{"how", how}});
}

}  // namespace musher::texts
