#include "musher/test/campaign/faults/promise.hpp"

namespace musher::campaign {
namespace {

// The machine's state is never raised by a loss.
std::string Lower(const std::string& state, const std::string& on_lost) {
  return on_lost.empty() || RankOf(on_lost) > RankOf(state) ? state : on_lost;
}

}  // namespace

Promise PromiseFor(const std::string& victim, Loss loss, const std::string& state) {
  const Member& member = MemberOf(victim);
  const bool restarted =
      member.restart == "always" || (member.restart == "on-failure" && loss != Loss::kClean);
  if (restarted && loss != Loss::kForGood) return {state, true};
  return {Lower(state, member.on_lost), false};
}

void AwaitPromise(Trial& trial, const std::string& victim, Loss loss) {
  const Promise promise = PromiseFor(victim, loss, trial.state());
  if (promise.back) return trial.RecoveredIn(promise.state);
  trial.Recovered(victim + " is gone, the others are in " + promise.state,
                  [&](const msg::MachineStatus& status) {
                    const msg::ActuatorInfo& info = Find(status, victim);
                    return IsSettled(status, promise.state, {victim}) && info.degraded &&
                           info.presence != "present" && !info.restarting;
                  });
  // A person brings it back.
  Relieve(trial.robot.board(victim));
  const auto answer = trial.observer().Restart(victim);
  trial.Require(answer.ok() && answer.value().code == 0,
                "musher restart " + victim +
                    " fails: " + (answer.ok() ? answer.value().reason : answer.error().message));
  trial.Require(trial.observer()
                    .Await([&](const auto& s) { return IsSettled(s, promise.state); }, kPatience)
                    .has_value(),
                victim + " does not come back by hand");
}

Observer::Is IsKnownAs(const std::string& actuator, const std::string& health) {
  return [=](const msg::MachineStatus& status) {
    const msg::ActuatorInfo& info = Find(status, actuator);
    return health.empty() ? info.presence == "lost" : info.health == health;
  };
}

}  // namespace musher::campaign
