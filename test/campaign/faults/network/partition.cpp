// The hosts do not hear each other, or one of them does not.

#include <signal.h>

#include "musher/test/campaign/faults/network.hpp"
#include "musher/test/campaign/faults/promise.hpp"

namespace musher::campaign::network {
namespace {

const Weather kCut{100, 0, {}, {}};

// Where the machine goes when all are lost: never up.
std::string WithoutAnybody(const std::string& state) {
  const std::string without_legs = PromiseFor("legs", Loss::kForGood, state).state;
  return PromiseFor("planner", Loss::kForGood, without_legs).state;
}

bool AllAre(const msg::MachineStatus& status, const std::string& health) {
  return std::all_of(status.actuators.begin(), status.actuators.end(),
                     [&](const auto& info) { return info.health == health; });
}

void AwaitAllPartitioned(Trial& trial) {
  trial.Detected("all are partitioned",
                 [](const auto& status) { return AllAre(status, "partitioned"); });
}

// Back, but nowhere that is more active than before.
void RecoveredDown(Trial& trial) {
  const int before = RankOf(trial.state());
  trial.Recovered("settled again", [before](const auto& status) {
    const int rank = RankOf(status.state);
    return rank >= 0 && rank <= before && IsSettled(status, status.state);
  });
}

Duration DrawnTime(Trial& trial, int low_ms, int high_ms) {
  const auto time = trial.random.Between(low_ms, high_ms);
  trial.Drawn("for", std::to_string(time) + " ms");
  return Milliseconds(time);
}

}  // namespace

void IsCut(Trial& trial) {
  trial.MayAllBeHurt();
  const Duration more = DrawnTime(trial, 0, 3000);
  Cable& cable = trial.robot.far_host()->cable();
  trial.Struck();
  cable.Set(kCut, kCut, 0);
  AwaitAllPartitioned(trial);
  const std::string state = WithoutAnybody(trial.state());
  trial.Require(trial.observer()
                    .Await([&](const auto& s) { return s.state == state; }, kPatience)
                    .has_value(),
                "without its actuators the machine does not go to " + state);
  trial.LetPass(more);
  trial.Struck(Trial::Clock::kRecovery);
  cable.Heal();
  trial.RecoveredIn(state);
}

void IsMute(Trial& trial) {
  trial.MayAllBeHurt();
  const Duration more = DrawnTime(trial, 0, 2000);
  Cable& cable = trial.robot.far_host()->cable();
  trial.Struck();
  cable.Set({}, kCut, 0);
  AwaitAllPartitioned(trial);
  trial.LetPass(more);
  trial.Struck(Trial::Clock::kRecovery);
  cable.Heal();
  RecoveredDown(trial);
}

// They are heard, so they are not lost; without a controller they go where they go without one.
void IsDeaf(Trial& trial, bool beyond_lease) {
  trial.MayAllBeHurt();
  Cable& cable = trial.robot.far_host()->cable();
  const bool leave = RankOf(trial.state()) > RankOf(kOnControllerLost);
  // The lease of a participant is 2 s with the lan profile.
  const Duration more = beyond_lease ? DrawnTime(trial, 2500, 4000)
                        : leave      ? DrawnTime(trial, 0, 200)
                                     : DrawnTime(trial, 0, 1700);
  trial.Struck();
  cable.Set(kCut, {}, 0);
  if (leave) {
    trial.Detected("all have gone to Protected by themselves", [](const auto& status) {
      return std::all_of(status.actuators.begin(), status.actuators.end(),
                         [](const auto& info) { return info.state == kOnControllerLost; });
    });
  }
  trial.LetPass(more);
  trial.Struck(Trial::Clock::kRecovery);
  cable.Heal();
  RecoveredDown(trial);
}

void IsCutInSwitch(Trial& trial) {
  trial.MayAllBeHurt();
  const std::string target = trial.state() == "Active" ? "LowPower" : "Active";
  trial.MayBecome(target);
  for (const std::string& name : Modules()) trial.robot.board(name).callback_ms = 100;
  Cable& cable = trial.robot.far_host()->cable();
  const auto begun =
      trial.observer().Once([target](const auto& status) { return status.target == target; },
                            [&cable] { cable.Set(kCut, kCut, 0); });
  const auto answer = trial.observer().SetState(target);
  Answer(begun);
  trial.Struck();
  const auto result = Answer(answer);
  const bool up = target == "Active";
  trial.ExpectOutcome(result, up ? "undone" : "done-degraded");
  AwaitAllPartitioned(trial);
  for (const std::string& name : Modules()) Relieve(trial.robot.board(name));
  trial.Struck(Trial::Clock::kRecovery);
  cable.Heal();
  trial.RecoveredIn(WithoutAnybody(up ? trial.state() : target));
}

void LinkGoesDown(Trial& trial) {
  trial.MayAllBeHurt();
  const bool there = trial.random.Chance(50);
  trial.Drawn("end", there ? "of the actuators" : "of the controller");
  const Duration more = DrawnTime(trial, 0, 1500);
  Cable& cable = trial.robot.far_host()->cable();
  trial.Struck();
  cable.LinkDown(there);
  AwaitAllPartitioned(trial);
  trial.LetPass(more);
  trial.Struck(Trial::Clock::kRecovery);
  cable.LinkUp(there);
  RecoveredDown(trial);
}

// The machine is taken down while its host has no network: the controller ends in its time.
void StoppedWithoutLink(Trial& trial) {
  trial.RobotIsTornDown();
  trial.ControllerMayDie();
  Cable& cable = trial.robot.far_host()->cable();
  cable.LinkDown(false);
  trial.Struck();
  kill(trial.robot.ControllerPid(), SIGTERM);
  const bool ended = trial.robot.AwaitControllerEnd(2 * Milliseconds(kShutdownBudgetMs));
  if (ended) trial.RecoveredNow();
  cable.LinkUp(false);
  trial.Expect(ended, "without a network the controller does not end in twice its budget");
}

void KilledFarAway(Trial& trial) {
  const std::string victim = trial.Victim({"arm", "eyes", "hands"});
  const pid_t pid = trial.robot.PidOf(victim);
  trial.Require(pid > 0, victim + " has no process");
  trial.Struck();
  kill(pid, SIGKILL);
  trial.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  trial.RecoveredIn(trial.state());
}

}  // namespace musher::campaign::network
