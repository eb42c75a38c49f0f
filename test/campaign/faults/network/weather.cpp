// Packets are lost, late, doubled or out of order: switches have their outcome all the same.

#include "musher/test/campaign/faults/network.hpp"

namespace musher::campaign::network {
namespace {

// So many lost packets nobody may be taken for lost.
constexpr int kHarmlessLoss = 10;

std::string Other(const Trial& trial) {
  return trial.state() == "DeActive" ? "Active" : "DeActive";
}

// A switch there and one back while the weather lasts.
void SwitchIn(Trial& trial, const Weather& weather, bool harmless) {
  const std::string target = Other(trial);
  trial.MayBecome(target);
  if (!harmless) trial.MayAllBeHurt();
  Cable& cable = trial.robot.far_host()->cable();
  trial.Struck();
  cable.Set(weather, weather, trial.random.Next());
  const auto there = Answer(trial.observer().SetState(target));
  trial.Expect(there.ok(), "the switch has no outcome");
  if (harmless) trial.ExpectOutcome(there, "done");
  trial.LetPass(Milliseconds(trial.random.Between(300, 1500)));
  if (harmless) trial.ExpectOutcome(Answer(trial.observer().SetState(trial.state())), "done");
  cable.Heal();
  if (harmless) return trial.RecoveredIn(trial.state());
  trial.Recovered("settled again", [](const auto& status) {
    return RankOf(status.state) >= 0 && IsSettled(status, status.state);
  });
}

}  // namespace

void LosesPackets(Trial& trial) {
  Weather weather;
  weather.loss_percent = static_cast<int>(trial.random.Between(2, 50));
  trial.Drawn("percent", std::to_string(weather.loss_percent));
  SwitchIn(trial, weather, weather.loss_percent <= kHarmlessLoss);
}

void IsSlow(Trial& trial) {
  Weather weather;
  weather.delay = Milliseconds(trial.random.Between(5, 100));
  trial.Drawn("ms each way", std::to_string(ToMilliseconds(weather.delay)));
  SwitchIn(trial, weather, true);
}

void DoublesPackets(Trial& trial) {
  Weather weather;
  weather.duplicate_percent = static_cast<int>(trial.random.Between(20, 100));
  trial.Drawn("percent", std::to_string(weather.duplicate_percent));
  SwitchIn(trial, weather, true);
}

void ReordersPackets(Trial& trial) {
  Weather weather;
  weather.jitter = Milliseconds(trial.random.Between(2, 60));
  trial.Drawn("ms", std::to_string(ToMilliseconds(weather.jitter)));
  SwitchIn(trial, weather, true);
}

}  // namespace musher::campaign::network
