// Sentences about the machine, its controller, and TearDown.

#include "musher/base/words.hpp"
#include "musher/lifecycle/machine/machine_invariants.hpp"
#include "musher/lifecycle/record/texts.hpp"

namespace musher::texts {
namespace {

std::string SourceOf(const std::string& by) {
  return by.empty() ? "an unknown source" : "{by}";
}

}  // namespace

RecordText ControllerStarted(Epoch epoch, std::size_t actuators) {
  return MakeText(EventName::kControllerStarted,
                  "controller started: epoch {epoch}, {actuators} " + NounOf(actuators, "actuator"),
                  {{"epoch", epoch}, {"actuators", actuators}});
}

RecordText TearDownResumed() {
  return {EventName::kTearDownResumed,
          "the previous controller ended during TearDown; this one finishes it"};
}

RecordText TearDownResumedBySupervisor() {
  return {EventName::kTearDownResumed,
          "the previous controller was tearing the machine down; this start by a supervisor "
          "finishes that TearDown, and the machine stays down until `musher up` starts it"};
}

RecordText StageStarted(int stage) {
  return MakeText(EventName::kStageStarted, "starting stage {stage}", {{"stage", stage}});
}

RecordText ActuatorsSetUp(std::size_t present) {
  return MakeText(EventName::kActuatorsSetUp,
                  "{actuators} " + NounOf(present, "actuator is", "actuators are") + " set up",
                  {{"actuators", present}});
}

RecordText WaitingForManager(const std::vector<std::string>& missing) {
  std::string list;
  for (const std::string& actuator : missing) list += (list.empty() ? "" : "; ") + actuator;
  return MakeText(EventName::kWaitingForManager,
                  std::string("the machine waits in SetUp for a manager to configure it") +
                      (missing.empty() ? "" : "; {missing}"),
                  {{"missing", list}});
}

RecordText StartUpFailed(const State& state, const std::string& why) {
  return MakeText(EventName::kStartUpFailed,
                  "start-up failed, the machine stays in {state}: {reason}",
                  {{"state", state}, {"reason", why}});
}

RecordText UnfinishedSwitchFound(const std::string& elsewhere, const State& lowest) {
  return MakeText(EventName::kUnfinishedSwitchFound,
                  "a previous controller left a switch unfinished ({elsewhere}); finishing it in "
                  "{state}",
                  {{"elsewhere", elsewhere}, {"state", lowest}});
}

RecordText MixedStatesFound(const std::string& elsewhere, const State& lowest) {
  return MakeText(EventName::kMixedStatesFound,
                  "the least active state found is {state}; elsewhere: {elsewhere}",
                  {{"state", lowest}, {"elsewhere", elsewhere}});
}

RecordText MachineUsable(const State& state, const std::string& trouble) {
  return MakeText(
      EventName::kMachineUsable,
      trouble.empty() ? "the machine is {state}" : "the machine is {state}, degraded: {degraded}",
      {{"state", state}, {"degraded", trouble}});
}

RecordText MachineUsableWithoutActive() {
  return {EventName::kMachineUsable, "self-check done; the machine has no Active"};
}

RecordText MachineAdopted(const State& state) {
  return MakeText(EventName::kMachineAdopted, "the machine is adopted in {state}",
                  {{"state", state}});
}

RecordText InvariantBroken(const std::string& broken) {
  return MakeText(EventName::kInvariantBroken, kBrokenInvariant + std::string("{broken}"),
                  {{"broken", broken}});
}

RecordText StopIntentLate() {
  return {EventName::kStopIntentLate,
          "the stop intent is not on disk yet; TearDown begins anyway. If the controller ends "
          "before the save, a supervisor starts the machine again"};
}

RecordText MachineStopped(Duration took, const std::optional<std::string>& left) {
  return MakeText(EventName::kMachineStopped,
                  left ? "the machine is stopped after {took_ms} ms; {left}"
                       : "the machine is stopped after {took_ms} ms",
                  {{"took_ms", ToMilliseconds(took)}, {"left", left.value_or("")}});
}

RecordText ControllerFenced(Epoch epoch, const std::string& why) {
  return MakeText(EventName::kControllerFenced,
                  "this controller (epoch {epoch}) releases control: {reason}",
                  {{"epoch", epoch}, {"reason", why}});
}

RecordText EpochRaised(Epoch epoch, const std::string& actuator) {
  return MakeText(EventName::kEpochRaised,
                  "epoch {epoch}: {actuator} was controlled by epoch {other_epoch}",
                  {{"epoch", epoch}, {"actuator", actuator}, {"other_epoch", epoch - 1}});
}

RecordText SaveFailed(std::string_view what, const std::string& why) {
  return MakeText(EventName::kSaveFailed, "the {what} is not on disk: {reason}",
                  {{"what", std::string(what)}, {"reason", why}});
}

RecordText SaveRecovered(std::string_view what) {
  return MakeText(EventName::kSaveRecovered, "the {what} is on disk now",
                  {{"what", std::string(what)}});
}

RecordText UnlistedActuatorFound(const std::string& actuator, std::int32_t pid, const State& state,
                                 const std::string& config) {
  const std::string process = pid == 0 ? "" : "pid {pid}, ";
  return MakeText(
      EventName::kUnlistedActuator,
      "{actuator} runs (" + process +
          "in {state}), but {config} does not list it: it is "
          "not controlled. `musher down` and then `musher down --without-controller` stop "
          "it",
      {{"actuator", actuator}, {"pid", Known(pid)}, {"state", state}, {"config", config}});
}

RecordText OtherMachineSeen(const std::string& machine, const std::string& process,
                            const std::string& name_space) {
  return MakeText(
      EventName::kOtherMachine,
      "another machine, {machine}, runs in the same domain and in " +
          (name_space.empty() ? std::string("no namespace") : "the same namespace, {namespace}") +
          ": {process}. It is left alone, but data topics of both are mixed: give "
          "this one a `namespace` in [controller], or [security]",
      {{"machine", machine}, {"process", process}, {"namespace", name_space}});
}

RecordText EmergencyStopEngaged(const std::string& by, const std::string& reason) {
  return MakeText(
      EventName::kEmergencyStopEngaged,
      "emergency stop engaged by " + SourceOf(by) + (reason.empty() ? "" : ": {reason}"),
      {{"by", by}, {"reason", reason}});
}

RecordText EmergencyStopReleased(const std::string& by) {
  return MakeText(EventName::kEmergencyStopReleased,
                  "emergency stop released by " + SourceOf(by) + "; no state changes",
                  {{"by", by}});
}

RecordText StateNotWritable(const std::string& why) {
  return MakeText(
      EventName::kStateNotWritable,
      "the state folder cannot be written ({reason}): an emergency stop would be lost with "
      "the power, so the machine does not become Active by itself; `musher set Active` "
      "switches it",
      {{"reason", why}});
}

RecordText ReleaseUnconfirmed(const std::vector<std::string>& actuators) {
  std::string list;
  for (const std::string& actuator : actuators) list += (list.empty() ? "" : ", ") + actuator;
  return MakeText(
      EventName::kReleaseUnconfirmed,
      "the release of the emergency stop is not confirmed by {actuators}: they may still be "
      "stopped; release it again once they can be reached",
      {{"actuators", list}});
}

RecordText RuleViolated(const std::string& rule, const std::string& states) {
  return MakeText(EventName::kRuleViolated,
                  "a rule of yours is violated: {rule} ({states}); nothing is changed",
                  {{"rule", rule}, {"states", states}});
}

RecordText RequestRefused(const std::string& what, const std::string& why) {
  return MakeText(EventName::kRequestRefused, "{what} refused: {reason}",
                  {{"what", what}, {"reason", why}});
}

RecordText FallbackStarted(const State& target) {
  return MakeText(EventName::kFallbackStarted, "an actuator is lost; falling back to {target}",
                  {{"target", target}});
}

RecordText FallbackRefused(const State& target, const std::string& why) {
  return MakeText(EventName::kFallbackRefused, "cannot fall back to {target}: {reason}",
                  {{"target", target}, {"reason", why}});
}

RecordText ProcessFound(std::int32_t pid, const std::string& actuator) {
  return MakeText(EventName::kProcessFound,
                  "process {pid} of {actuator}, started by another controller, was found during "
                  "shutdown and is ended with the machine",
                  {{"pid", pid}, {"actuator", actuator}});
}

RecordText ProcessSignalled(const std::string& actuator, std::int32_t pid, bool kill) {
  return MakeText(EventName::kProcessSignalled,
                  "{actuator} has not ended; process {pid} gets {signal}",
                  {{"actuator", actuator}, {"pid", pid}, {"signal", kill ? "SIGKILL" : "SIGTERM"}});
}

RecordText ProcessLeftBehind(std::int32_t pid, const std::optional<std::string>& successor,
                             const std::string& host) {
  const std::string process = std::string(pid == 0 ? "its process " : "its process {pid} ") +
                              (host.empty() ? "" : "on host {host} ");
  const char* what =
      successor ? "had not ended when another controller, {successor}, took over" : "has not ended";
  return MakeText(EventName::kProcessLeftBehind, process + what,
                  {{"pid", Known(pid)}, {"successor", successor.value_or("")}, {"host", host}});
}

RecordText LeftToOther(std::int32_t pid, const std::string& host, const std::string& how) {
  return MakeText(EventName::kProcessLeftBehind,
                  "{how}: its process {pid} on host {host} is left to that machine",
                  {{"pid", pid}, {"host", host}, {"how", how}});
}

RecordText HostUnreached(const std::string& host, const std::string& why) {
  return MakeText(EventName::kMayStillRun,
                  host.empty() ? "it may still be started: {why}"
                               : "host {host} is out of reach, so it may still run there: {why}",
                  {{"host", host}, {"why", why}});
}

RecordText MayStillRun(const std::optional<State>& state) {
  const std::string where = state ? "{state}" : "an unknown state";
  return MakeText(EventName::kMayStillRun,
                  "connection lost and no exit seen; it may still run in " + where,
                  {{"state", state.value_or(State())}});
}

RecordText MayStillRunOn(const std::string& host) {
  const std::string where = host.empty() ? "on this or another host" : "on another host, {host}";
  return MakeText(EventName::kMayStillRun,
                  "no status received since this controller started; it may still run " + where +
                      ", where an earlier controller has left it (if it has exited, remove its "
                      "line from the file remote_actuators in the state folder)",
                  {{"host", host}});
}

RecordText LostWithoutTearDown(const State& state) {
  if (state == kUnknownState) {
    return MakeText(EventName::kLostWithoutTearDown,
                    "its process has ended, and its last state is not known; what it had switched "
                    "on may be on",
                    {});
  }
  return MakeText(EventName::kLostWithoutTearDown,
                  "its process has ended in {state} without its TearDown; what it had switched on "
                  "may be on",
                  {{"state", state}});
}

RecordText KeepsRunning(const State& state) {
  return MakeText(EventName::kMayStillRun,
                  "keeps running in {state}: it has no state TearDown, and the controller did not "
                  "start its process",
                  {{"state", state}});
}

}  // namespace musher::texts
