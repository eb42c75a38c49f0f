// The emergency stop: latched by all at once, undoes what was on its way up, changes no state.

#include "musher/test/campaign/faults/operation.hpp"

namespace musher::campaign::operation {
namespace {

// Those that latch it: all of the crew.
bool AllHaveLatched(Trial& trial, std::uint64_t id) {
  const auto said = trial.observer().LatestOfActuators();
  return std::all_of(said.begin(), said.end(),
                     [id](const auto& actuator) { return actuator.second.emergency_stop == id; });
}

void Stop(Trial& trial) {
  const std::uint64_t id = trial.random.Next() | 1U;
  trial.Struck();
  trial.observer().EngageEmergencyStop(id);
  trial.Require(AwaitThat([&] { return AllHaveLatched(trial, id); }, kPatience),
                "not all have latched the stop");
  trial.DetectedNow();
  trial.Require(trial.observer()
                    .AwaitSince(
                        trial.struck(), [](const auto& s) { return s.emergency_stop; }, kPatience)
                    .has_value(),
                "the status does not tell of the stop");
}

void Release(Trial& trial) {
  const auto released = trial.observer().ReleaseEmergencyStop();
  trial.Require(released.ok() && released.value().code == 0, "the stop cannot be released");
  trial.Require(AwaitThat([&] { return AllHaveLatched(trial, 0); }, kPatience),
                "not all have released the stop");
}

}  // namespace

void EmergencyStopAtRest(Trial& trial) {
  if (trial.state() == "Active") trial.MoveTo("DeActive");
  Stop(trial);
  const auto refused = Answer(trial.observer().SetState("Active"));
  trial.ExpectOutcome(refused, "refused");
  trial.RecoveredIn(trial.state());
  Release(trial);
  trial.Require(trial.observer()
                    .Await([&](const auto& s) { return IsSettled(s, trial.state()); }, kPatience)
                    .has_value(),
                "the release has changed something");
}

void EmergencyStopInSwitch(Trial& trial) {
  if (trial.state() == "Active") trial.MoveTo("LowPower");
  trial.MayBecome("Active");
  for (const std::string& name : Modules()) trial.robot.board(name).callback_ms = 150;
  const auto begun =
      trial.observer().Once([](const auto& status) { return status.target == "Active"; }, [] {});
  const auto answer = trial.observer().SetState("Active");
  Answer(begun);
  Stop(trial);
  trial.ExpectOutcome(Answer(answer), "undone");
  trial.RecoveredIn(trial.state());
  for (const std::string& name : Modules()) Relieve(trial.robot.board(name));
  Release(trial);
}

}  // namespace musher::campaign::operation
