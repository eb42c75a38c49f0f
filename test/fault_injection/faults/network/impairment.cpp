// Packets are lost, delayed, duplicated or reordered: every switch still has an outcome.

#include "musher/test/fault_injection/faults/network.hpp"

namespace musher::fault_injection::network {
namespace {

// Up to this loss of packets, in percent, no actuator may be reported as lost.
constexpr int kHarmlessLoss = 10;

std::string Other(const FaultRun& run) {
  return run.state() == "DeActive" ? "Active" : "DeActive";
}

// A switch and one back while the link is impaired.
void SwitchIn(FaultRun& run, const LinkImpairment& impairment, bool harmless) {
  const std::string target = Other(run);
  run.MayBecome(target);
  if (!harmless) run.MayAllBeAffected();
  Link& link = run.robot.far_host()->link();
  run.FaultInjected();
  link.Set(impairment, impairment, run.random.Next());
  const auto there = AwaitFuture(run.observer().SetState(target));
  run.Expect(there.ok(), "the switch has no outcome");
  if (harmless) run.ExpectOutcome(there, "done");
  run.LetPass(Milliseconds(run.random.Between(300, 1500)));
  if (harmless) run.ExpectOutcome(AwaitFuture(run.observer().SetState(run.state())), "done");
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
  run.Sampled("percent", std::to_string(impairment.loss_percent));
  SwitchIn(run, impairment, impairment.loss_percent <= kHarmlessLoss);
}

void IsSlow(FaultRun& run) {
  LinkImpairment impairment;
  impairment.delay = Milliseconds(run.random.Between(5, 100));
  run.Sampled("ms each way", std::to_string(ToMilliseconds(impairment.delay)));
  SwitchIn(run, impairment, true);
}

void DoublesPackets(FaultRun& run) {
  LinkImpairment impairment;
  impairment.duplicate_percent = static_cast<int>(run.random.Between(20, 100));
  run.Sampled("percent", std::to_string(impairment.duplicate_percent));
  SwitchIn(run, impairment, true);
}

void ReordersPackets(FaultRun& run) {
  LinkImpairment impairment;
  impairment.jitter = Milliseconds(run.random.Between(2, 60));
  run.Sampled("ms", std::to_string(ToMilliseconds(impairment.jitter)));
  SwitchIn(run, impairment, true);
}

}  // namespace musher::fault_injection::network
