#include "musher/test/fault_injection/faults/expectation.hpp"

namespace musher::fault_injection {
namespace {

// A loss never makes the machine more active.
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
  run.Recovered(victim + " is lost, the others are in " + expectation.state,
                [&](const msg::MachineStatus& status) {
                  const msg::ActuatorInfo& info = Find(status, victim);
                  return IsSettled(status, expectation.state, {victim}) && info.degraded &&
                         info.presence != "present" && !info.restarting;
                });
  // An operator restarts it.
  ClearFaults(run.robot.board(victim));
  const auto reply = run.observer().Restart(victim);
  run.Require(reply.ok() && reply.value().code == 0,
              "musher restart " + victim +
                  " fails: " + (reply.ok() ? reply.value().reason : reply.error().message));
  run.Require(run.observer()
                  .Await([&](const auto& s) { return IsSettled(s, expectation.state); }, kTimeout)
                  .has_value(),
              victim + " is not available after a restart by hand");
}

Observer::Is IsKnownAs(const std::string& actuator, const std::string& health) {
  return [=](const msg::MachineStatus& status) {
    const msg::ActuatorInfo& info = Find(status, actuator);
    return health.empty() ? info.presence == "lost" : info.health == health;
  };
}

}  // namespace musher::fault_injection
