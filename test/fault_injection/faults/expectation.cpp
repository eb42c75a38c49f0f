#include "musher/test/fault_injection/faults/expectation.hpp"

namespace musher::fault_injection {
namespace {

// The machine's state is never raised by a loss.
std::string Lower(const std::string& state, const std::string& on_lost) {
  return on_lost.empty() || RankOf(on_lost) > RankOf(state) ? state : on_lost;
}

}  // namespace

Expectation ExpectationFor(const std::string& victim, Loss loss, const std::string& state) {
  const Member& member = MemberOf(victim);
  const bool restarted =
      member.restart == "always" || (member.restart == "on-failure" && loss != Loss::kClean);
  if (restarted && loss != Loss::kForGood) return {state, true};
  return {Lower(state, member.on_lost), false};
}

void AwaitExpectation(FaultRun& run, const std::string& victim, Loss loss) {
  const Expectation expectation = ExpectationFor(victim, loss, run.state());
  if (expectation.back) return run.RecoveredIn(expectation.state);
  run.Recovered(victim + " is gone, the others are in " + expectation.state,
                [&](const msg::MachineStatus& status) {
                  const msg::ActuatorInfo& info = Find(status, victim);
                  return IsSettled(status, expectation.state, {victim}) && info.degraded &&
                         info.presence != "present" && !info.restarting;
                });
  // A person brings it back.
  Relieve(run.robot.board(victim));
  const auto answer = run.observer().Restart(victim);
  run.Require(answer.ok() && answer.value().code == 0,
              "musher restart " + victim +
                  " fails: " + (answer.ok() ? answer.value().reason : answer.error().message));
  run.Require(run.observer()
                  .Await([&](const auto& s) { return IsSettled(s, expectation.state); }, kPatience)
                  .has_value(),
              victim + " does not come back by hand");
}

Observer::Is IsKnownAs(const std::string& actuator, const std::string& health) {
  return [=](const msg::MachineStatus& status) {
    const msg::ActuatorInfo& info = Find(status, actuator);
    return health.empty() ? info.presence == "lost" : info.health == health;
  };
}

}  // namespace musher::fault_injection
