// Packets are lost, late, doubled or out of order: switches have their outcome all the same.

#include "musher/test/fault_injection/faults/network.hpp"

namespace musher::fault_injection::network {
namespace {

// So many lost packets nobody may be taken for lost.
constexpr int kHarmlessLoss = 10;

std::string Other(const FaultRun& run) {
  return run.state() == "DeActive" ? "Active" : "DeActive";
}

// A switch there and one back while the weather lasts.
void SwitchIn(FaultRun& run, const LinkImpairment& impairment, bool harmless) {
  const std::string target = Other(run);
  run.MayBecome(target);
  if (!harmless) run.MayAllBeHurt();
  Link& link = run.robot.far_host()->link();
  run.Struck();
  link.Set(impairment, impairment, run.random.Next());
  const auto there = Answer(run.observer().SetState(target));
  run.Expect(there.ok(), "the switch has no outcome");
  if (harmless) run.ExpectOutcome(there, "done");
  run.LetPass(Milliseconds(run.random.Between(300, 1500)));
  if (harmless) run.ExpectOutcome(Answer(run.observer().SetState(run.state())), "done");
  link.Heal();
  if (harmless) return run.RecoveredIn(run.state());
  run.Recovered("settled again", [](const auto& status) {
    return RankOf(status.state) >= 0 && IsSettled(status, status.state);
  });
}

}  // namespace

void LosesPackets(FaultRun& run) {
  LinkImpairment impairment;
  impairment.loss_percent = static_cast<int>(run.random.Between(2, 50));
  run.Drawn("percent", std::to_string(impairment.loss_percent));
  SwitchIn(run, impairment, impairment.loss_percent <= kHarmlessLoss);
}

void IsSlow(FaultRun& run) {
  LinkImpairment impairment;
  impairment.delay = Milliseconds(run.random.Between(5, 100));
  run.Drawn("ms each way", std::to_string(ToMilliseconds(impairment.delay)));
  SwitchIn(run, impairment, true);
}

void DoublesPackets(FaultRun& run) {
  LinkImpairment impairment;
  impairment.duplicate_percent = static_cast<int>(run.random.Between(20, 100));
  run.Drawn("percent", std::to_string(impairment.duplicate_percent));
  SwitchIn(run, impairment, true);
}

void ReordersPackets(FaultRun& run) {
  LinkImpairment impairment;
  impairment.jitter = Milliseconds(run.random.Between(2, 60));
  run.Drawn("ms", std::to_string(ToMilliseconds(impairment.jitter)));
  SwitchIn(run, impairment, true);
}

}  // namespace musher::fault_injection::network
