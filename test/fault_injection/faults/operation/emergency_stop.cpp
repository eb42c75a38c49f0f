// The emergency stop: latched by all at once, undoes what was on its way up, changes no state.

#include "musher/test/fault_injection/faults/operation.hpp"

namespace musher::fault_injection::operation {
namespace {

// Those that latch it: all of the crew.
bool AllHaveLatched(FaultRun& run, std::uint64_t id) {
  const auto said = run.observer().LatestOfActuators();
  return std::all_of(said.begin(), said.end(),
                     [id](const auto& actuator) { return actuator.second.emergency_stop == id; });
}

void Stop(FaultRun& run) {
  const std::uint64_t id = run.random.Next() | 1U;
  run.Struck();
  run.observer().EngageEmergencyStop(id);
  run.Require(AwaitThat([&] { return AllHaveLatched(run, id); }, kPatience),
              "not all have latched the stop");
  run.DetectedNow();
  run.Require(run.observer()
                  .AwaitSince(
                      run.struck(), [](const auto& s) { return s.emergency_stop; }, kPatience)
                  .has_value(),
              "the status does not tell of the stop");
}

void Release(FaultRun& run) {
  const auto released = run.observer().ReleaseEmergencyStop();
  run.Require(released.ok() && released.value().code == 0, "the stop cannot be released");
  run.Require(AwaitThat([&] { return AllHaveLatched(run, 0); }, kPatience),
              "not all have released the stop");
}

}  // namespace

void EmergencyStopAtRest(FaultRun& run) {
  if (run.state() == "Active") run.MoveTo("DeActive");
  Stop(run);
  const auto refused = Answer(run.observer().SetState("Active"));
  run.ExpectOutcome(refused, "refused");
  run.RecoveredIn(run.state());
  Release(run);
  run.Require(run.observer()
                  .Await([&](const auto& s) { return IsSettled(s, run.state()); }, kPatience)
                  .has_value(),
              "the release has changed something");
}

void EmergencyStopInSwitch(FaultRun& run) {
  if (run.state() == "Active") run.MoveTo("LowPower");
  run.MayBecome("Active");
  for (const std::string& name : Modules()) run.robot.board(name).callback_ms = 150;
  const auto begun =
      run.observer().Once([](const auto& status) { return status.target == "Active"; }, [] {});
  const auto answer = run.observer().SetState("Active");
  Answer(begun);
  Stop(run);
  run.ExpectOutcome(Answer(answer), "undone");
  run.RecoveredIn(run.state());
  for (const std::string& name : Modules()) Relieve(run.robot.board(name));
  Release(run);
}

}  // namespace musher::fault_injection::operation
