// The link between the hosts is cut, in both directions or one.

#include <signal.h>

#include "musher/test/fault_injection/faults/expectation.hpp"
#include "musher/test/fault_injection/faults/network.hpp"

namespace musher::fault_injection::network {
namespace {

const LinkImpairment kCut{100, 0, {}, {}};

// The machine's state when all actuators are lost: never more active.
std::string WithoutActuators(const std::string& state) {
  const std::string without_legs = ExpectationFor("legs", Loss::kForGood, state).state;
  return ExpectationFor("planner", Loss::kForGood, without_legs).state;
}

bool AllAre(const msg::MachineStatus& status, const std::string& health) {
  return std::all_of(status.actuators.begin(), status.actuators.end(),
                     [&](const auto& info) { return info.health == health; });
}

void AwaitAllPartitioned(FaultRun& run) {
  run.Detected("all are partitioned",
               [](const auto& status) { return AllAre(status, "partitioned"); });
}

// Settled again, in no more active state than before.
void RecoveredDown(FaultRun& run) {
  const int before = RankOf(run.state());
  run.Recovered("settled again", [before](const auto& status) {
    const int rank = RankOf(status.state);
    return rank >= 0 && rank <= before && IsSettled(status, status.state);
  });
}

Duration SampledTime(FaultRun& run, int low_ms, int high_ms) {
  const auto time = run.random.Between(low_ms, high_ms);
  run.Sampled("for", std::to_string(time) + " ms");
  return Milliseconds(time);
}

}  // namespace

void IsCut(FaultRun& run) {
  run.MayAllBeAffected();
  const Duration more = SampledTime(run, 0, 3000);
  Link& link = run.robot.far_host()->link();
  run.FaultInjected();
  link.Set(kCut, kCut, 0);
  AwaitAllPartitioned(run);
  const std::string state = WithoutActuators(run.state());
  run.Require(
      run.observer().Await([&](const auto& s) { return s.state == state; }, kTimeout).has_value(),
      "without its actuators the machine does not go to " + state);
  run.LetPass(more);
  run.FaultInjected(FaultRun::Clock::kRecovery);
  link.Heal();
  run.RecoveredIn(state);
}

void IsMute(FaultRun& run) {
  run.MayAllBeAffected();
  const Duration more = SampledTime(run, 0, 2000);
  Link& link = run.robot.far_host()->link();
  run.FaultInjected();
  link.Set({}, kCut, 0);
  AwaitAllPartitioned(run);
  run.LetPass(more);
  run.FaultInjected(FaultRun::Clock::kRecovery);
  link.Heal();
  RecoveredDown(run);
}

// Their reports arrive, so they are not lost; without heartbeats they switch to on_controller_lost.
void IsDeaf(FaultRun& run, bool beyond_lease) {
  run.MayAllBeAffected();
  Link& link = run.robot.far_host()->link();
  const bool leave = RankOf(run.state()) > RankOf(kOnControllerLost);
  // The lease of a participant is 2 s with the lan profile.
  const Duration more = beyond_lease ? SampledTime(run, 2500, 4000)
                        : leave      ? SampledTime(run, 0, 200)
                                     : SampledTime(run, 0, 1700);
  run.FaultInjected();
  link.Set(kCut, {}, 0);
  if (leave) {
    run.Detected("all have switched to Protected by themselves", [](const auto& status) {
      return std::all_of(status.actuators.begin(), status.actuators.end(),
                         [](const auto& info) { return info.state == kOnControllerLost; });
    });
  }
  run.LetPass(more);
  run.FaultInjected(FaultRun::Clock::kRecovery);
  link.Heal();
  RecoveredDown(run);
}

void IsCutInSwitch(FaultRun& run) {
  run.MayAllBeAffected();
  const std::string target = run.state() == "Active" ? "LowPower" : "Active";
  run.MayBecome(target);
  for (const std::string& name : Modules()) run.robot.board(name).callback_ms = 100;
  Link& link = run.robot.far_host()->link();
  const auto began =
      run.observer().Once([target](const auto& status) { return status.target == target; },
                          [&link] { link.Set(kCut, kCut, 0); });
  const auto reply = run.observer().SetState(target);
  AwaitFuture(began);
  run.FaultInjected();
  const auto result = AwaitFuture(reply);
  const bool up = target == "Active";
  run.ExpectOutcome(result, up ? "undone" : "done-degraded");
  AwaitAllPartitioned(run);
  for (const std::string& name : Modules()) ClearFaults(run.robot.board(name));
  run.FaultInjected(FaultRun::Clock::kRecovery);
  link.Heal();
  run.RecoveredIn(WithoutActuators(up ? run.state() : target));
}

void LinkGoesDown(FaultRun& run) {
  run.MayAllBeAffected();
  const bool there = run.random.Bernoulli(50);
  run.Sampled("end", there ? "of the actuators" : "of the controller");
  const Duration more = SampledTime(run, 0, 1500);
  Link& link = run.robot.far_host()->link();
  run.FaultInjected();
  link.LinkDown(there);
  AwaitAllPartitioned(run);
  run.LetPass(more);
  run.FaultInjected(FaultRun::Clock::kRecovery);
  link.LinkUp(there);
  RecoveredDown(run);
}

// The machine is taken down while its host has no network: the controller ends in its time.
void StoppedWithoutLink(FaultRun& run) {
  run.RobotIsTornDown();
  run.ControllerMayDie();
  Link& link = run.robot.far_host()->link();
  link.LinkDown(false);
  run.FaultInjected();
  kill(run.robot.RunningController(), SIGTERM);
  const bool ended = run.robot.AwaitControllerEnd(2 * Milliseconds(kShutdownBudgetMs));
  if (ended) run.RecoveredNow();
  link.LinkUp(false);
  run.Expect(ended, "without a network the controller does not end in twice its budget");
}

void KilledOnOtherHost(FaultRun& run) {
  const std::string victim = run.Victim({"arm", "eyes", "hands"});
  const pid_t pid = run.robot.PidOf(victim);
  run.FaultInjected();
  kill(pid, SIGKILL);
  run.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  run.RecoveredIn(run.state());
}

}  // namespace musher::fault_injection::network
