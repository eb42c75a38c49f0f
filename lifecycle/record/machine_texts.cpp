// Of the machine and its controller, and of TearDown.

#include "musher/base/words.hpp"
#include "musher/lifecycle/machine/machine_invariants.hpp"
#include "musher/lifecycle/record/texts.hpp"

namespace musher::texts {
namespace {

std::string SourceOf(const std::string& by) {
  return by.empty() ? "an unknown source" : by;
}

}  // namespace

RecordText ControllerStarted(Epoch epoch, std::size_t actuators) {
  return {EventName::kControllerStarted,
          "controller started: epoch " + ToString(epoch) + ", " + Counted(actuators, "actuator")};
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
  return {EventName::kStageStarted, "starting stage " + std::to_string(stage)};
}

RecordText ActuatorsSetUp(std::size_t present) {
  return {EventName::kActuatorsSetUp, Counted(present, "actuator is", "actuators are") + " set up"};
}

RecordText WaitingForManager(const std::vector<std::string>& missing) {
  std::string message = "the machine waits in SetUp for a manager to configure it";
  for (const std::string& actuator : missing) message += "; " + actuator;
  return {EventName::kWaitingForManager, message};
}

RecordText StartUpFailed(const State& state, const std::string& why) {
  return {EventName::kStartUpFailed, "start-up failed, the machine stays in " + state + ": " + why};
}

RecordText UnfinishedSwitchFound(const std::string& elsewhere, const State& lowest) {
  return {EventName::kUnfinishedSwitchFound, "a previous controller left a switch unfinished (" +
                                                 elsewhere + "); finishing it in " + lowest};
}

RecordText MixedStatesFound(const std::string& elsewhere, const State& lowest) {
  return {EventName::kMixedStatesFound,
          "the least active state found is " + lowest + "; elsewhere: " + elsewhere};
}

RecordText MachineUsable(const State& state, const std::string& trouble) {
  return {EventName::kMachineUsable,
          "the machine is " + state + (trouble.empty() ? "" : ", degraded: " + trouble)};
}

RecordText MachineUsableWithoutActive() {
  return {EventName::kMachineUsable, "self-check done; the machine has no Active"};
}

RecordText MachineAdopted(const State& state) {
  return {EventName::kMachineAdopted, "the machine is adopted in " + state};
}

RecordText InvariantBroken(const std::string& broken) {
  return {EventName::kInvariantBroken, kBrokenInvariant + broken};
}

RecordText StopIntentLate() {
  return {EventName::kStopIntentLate,
          "the stop intent is not on disk yet; TearDown begins anyway. If the controller ends "
          "before the save, a supervisor starts the machine again"};
}

RecordText MachineStopped(Duration took, const std::optional<std::string>& left) {
  return {EventName::kMachineStopped, "the machine is stopped after " +
                                          std::to_string(ToMilliseconds(took)) + " ms" +
                                          (left ? "; " + *left : "")};
}

RecordText ControllerFenced(Epoch epoch, const std::string& why) {
  return {EventName::kControllerFenced,
          "this controller (epoch " + ToString(epoch) + ") releases control: " + why};
}

RecordText EpochRaised(Epoch epoch, const std::string& actuator) {
  return {EventName::kEpochRaised, "epoch " + ToString(epoch) + ": " + actuator +
                                       " was controlled by epoch " + ToString(epoch - 1)};
}

RecordText SaveFailed(std::string_view what, const std::string& why) {
  return {EventName::kSaveFailed, "the " + std::string(what) + " is not on disk: " + why};
}

RecordText SaveRecovered(std::string_view what) {
  return {EventName::kSaveRecovered, "the " + std::string(what) + " is on disk now"};
}

RecordText EmergencyStopEngaged(const std::string& by, const std::string& reason) {
  return {EventName::kEmergencyStopEngaged,
          "emergency stop engaged by " + SourceOf(by) + (reason.empty() ? "" : ": " + reason)};
}

RecordText EmergencyStopReleased(const std::string& by) {
  return {EventName::kEmergencyStopReleased,
          "emergency stop released by " + SourceOf(by) + "; no state changes"};
}

RecordText FallbackStarted(const State& target) {
  return {EventName::kFallbackStarted, "an actuator is lost; falling back to " + target};
}

RecordText FallbackRefused(const State& target, const std::string& why) {
  return {EventName::kFallbackRefused, "cannot fall back to " + target + ": " + why};
}

RecordText ProcessFound(std::int32_t pid, const std::string& actuator) {
  return {EventName::kProcessFound, "process " + std::to_string(pid) + " of " + actuator +
                                        ", started by another controller, was found during "
                                        "shutdown and is ended with the machine"};
}

RecordText ProcessSignalled(const std::string& actuator, std::int32_t pid, bool kill) {
  return {EventName::kProcessSignalled, actuator + " has not ended; process " +
                                            std::to_string(pid) +
                                            (kill ? " gets SIGKILL" : " gets SIGTERM")};
}

RecordText ProcessLeftBehind(std::int32_t pid, const std::optional<std::string>& successor) {
  const std::string process =
      pid == 0 ? "its process " : "its process " + std::to_string(pid) + " ";
  return {
      EventName::kProcessLeftBehind,
      process + (successor ? "had not ended when another controller, " + *successor + ", took over"
                           : "has not ended")};
}

RecordText MayStillRun(const std::optional<State>& state) {
  return {EventName::kMayStillRun, "connection lost and no exit seen; it may still run in " +
                                       state.value_or("an unknown state")};
}

RecordText MayStillRunOn(const std::string& host) {
  return {EventName::kMayStillRun,
          "no status received since this controller started; it may still run " +
              (host.empty() ? "on this or another host" : "on another host, " + host) +
              ", where an earlier controller has left it (if it has exited, remove its line from "
              "the file remote_actuators in the state folder)"};
}

}  // namespace musher::texts
