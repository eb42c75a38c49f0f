// The emergency stop: all actuators latch it at once, a switch up is undone, the state stays.

#include "musher/test/fault_injection/faults/operation.hpp"

namespace musher::fault_injection::operation {
namespace {

// Whether all actuators have latched the stop `id`; 0: none.
bool AllHaveLatched(FaultRun& run, StopId id) {
  const auto reports = run.observer().LatestOfActuators();
  return std::all_of(reports.begin(), reports.end(), [id](const auto& actuator) {
    return StopId(actuator.second.emergency_stop) == id;
  });
}

void EngageStop(FaultRun& run) {
  const StopId id(run.random.Next() | 1U);
  run.FaultInjected();
  run.observer().EngageEmergencyStop(id);
  run.Require(AwaitThat([&] { return AllHaveLatched(run, id); }, kTimeout),
              "not all have latched the stop");
  run.DetectedNow();
  run.Require(run.observer()
                  .AwaitSince(
                      run.injected_at(), [](const auto& s) { return s.emergency_stop; }, kTimeout)
                  .has_value(),
              "the status does not report the stop");
}

void Release(FaultRun& run) {
  const auto released = run.observer().ReleaseEmergencyStop();
  run.Require(released.ok() && released.value().code == 0, "the stop cannot be released");
  run.Require(AwaitThat([&] { return AllHaveLatched(run, 0); }, kTimeout),
              "not all have released the stop");
}

}  // namespace

void EmergencyStopAtRest(FaultRun& run) {
  if (run.state() == "Active") run.MoveTo("DeActive");
  EngageStop(run);
  const auto refused = AwaitFuture(run.observer().SetState("Active"));
  run.ExpectOutcome(refused, "refused");
  run.RecoveredIn(run.state());
  Release(run);
  run.Require(run.observer()
                  .Await([&](const auto& s) { return IsSettled(s, run.state()); }, kTimeout)
                  .has_value(),
              "the release has changed the state");
}

void EmergencyStopInSwitch(FaultRun& run) {
  if (run.state() == "Active") run.MoveTo("LowPower");
  run.MayBecome("Active");
  for (const std::string& name : Modules()) run.robot.board(name).callback_ms = 150;
  const auto began =
      run.observer().Once([](const auto& status) { return status.target == "Active"; }, [] {});
  const auto reply = run.observer().SetState("Active");
  AwaitFuture(began);
  EngageStop(run);
  run.ExpectOutcome(AwaitFuture(reply), "undone");
  run.RecoveredIn(run.state());
  for (const std::string& name : Modules()) ClearFaults(run.robot.board(name));
  Release(run);
}

}  // namespace musher::fault_injection::operation
