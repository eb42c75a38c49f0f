// The hosts do not hear each other, or one of them does not.

#include <signal.h>

#include "musher/test/fault_injection/faults/expectation.hpp"
#include "musher/test/fault_injection/faults/network.hpp"

namespace musher::fault_injection::network {
namespace {

const LinkImpairment kCut{100, 0, {}, {}};

// Where the machine goes when all are lost: never up.
std::string WithoutAnybody(const std::string& state) {
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

// Back, but nowhere that is more active than before.
void RecoveredDown(FaultRun& run) {
  const int before = RankOf(run.state());
  run.Recovered("settled again", [before](const auto& status) {
    const int rank = RankOf(status.state);
    return rank >= 0 && rank <= before && IsSettled(status, status.state);
  });
}

Duration DrawnTime(FaultRun& run, int low_ms, int high_ms) {
  const auto time = run.random.Between(low_ms, high_ms);
  run.Drawn("for", std::to_string(time) + " ms");
  return Milliseconds(time);
}

}  // namespace

void IsCut(FaultRun& run) {
  run.MayAllBeHurt();
  const Duration more = DrawnTime(run, 0, 3000);
  Link& link = run.robot.far_host()->link();
  run.Struck();
  link.Set(kCut, kCut, 0);
  AwaitAllPartitioned(run);
  const std::string state = WithoutAnybody(run.state());
  run.Require(
      run.observer().Await([&](const auto& s) { return s.state == state; }, kPatience).has_value(),
      "without its actuators the machine does not go to " + state);
  run.LetPass(more);
  run.Struck(FaultRun::Clock::kRecovery);
  link.Heal();
  run.RecoveredIn(state);
}

void IsMute(FaultRun& run) {
  run.MayAllBeHurt();
  const Duration more = DrawnTime(run, 0, 2000);
  Link& link = run.robot.far_host()->link();
  run.Struck();
  link.Set({}, kCut, 0);
  AwaitAllPartitioned(run);
  run.LetPass(more);
  run.Struck(FaultRun::Clock::kRecovery);
  link.Heal();
  RecoveredDown(run);
}

// They are heard, so they are not lost; without a controller they go where they go without one.
void IsDeaf(FaultRun& run, bool beyond_lease) {
  run.MayAllBeHurt();
  Link& link = run.robot.far_host()->link();
  const bool leave = RankOf(run.state()) > RankOf(kOnControllerLost);
  // The lease of a participant is 2 s with the lan profile.
  const Duration more = beyond_lease ? DrawnTime(run, 2500, 4000)
                        : leave      ? DrawnTime(run, 0, 200)
                                     : DrawnTime(run, 0, 1700);
  run.Struck();
  link.Set(kCut, {}, 0);
  if (leave) {
    run.Detected("all have gone to Protected by themselves", [](const auto& status) {
      return std::all_of(status.actuators.begin(), status.actuators.end(),
                         [](const auto& info) { return info.state == kOnControllerLost; });
    });
  }
  run.LetPass(more);
  run.Struck(FaultRun::Clock::kRecovery);
  link.Heal();
  RecoveredDown(run);
}

void IsCutInSwitch(FaultRun& run) {
  run.MayAllBeHurt();
  const std::string target = run.state() == "Active" ? "LowPower" : "Active";
  run.MayBecome(target);
  for (const std::string& name : Modules()) run.robot.board(name).callback_ms = 100;
  Link& link = run.robot.far_host()->link();
  const auto begun =
      run.observer().Once([target](const auto& status) { return status.target == target; },
                          [&link] { link.Set(kCut, kCut, 0); });
  const auto answer = run.observer().SetState(target);
  Answer(begun);
  run.Struck();
  const auto result = Answer(answer);
  const bool up = target == "Active";
  run.ExpectOutcome(result, up ? "undone" : "done-degraded");
  AwaitAllPartitioned(run);
  for (const std::string& name : Modules()) Relieve(run.robot.board(name));
  run.Struck(FaultRun::Clock::kRecovery);
  link.Heal();
  run.RecoveredIn(WithoutAnybody(up ? run.state() : target));
}

void LinkGoesDown(FaultRun& run) {
  run.MayAllBeHurt();
  const bool there = run.random.Chance(50);
  run.Drawn("end", there ? "of the actuators" : "of the controller");
  const Duration more = DrawnTime(run, 0, 1500);
  Link& link = run.robot.far_host()->link();
  run.Struck();
  link.LinkDown(there);
  AwaitAllPartitioned(run);
  run.LetPass(more);
  run.Struck(FaultRun::Clock::kRecovery);
  link.LinkUp(there);
  RecoveredDown(run);
}

// The machine is taken down while its host has no network: the controller ends in its time.
void StoppedWithoutLink(FaultRun& run) {
  run.RobotIsTornDown();
  run.ControllerMayDie();
  Link& link = run.robot.far_host()->link();
  link.LinkDown(false);
  run.Struck();
  kill(run.robot.LivingController(), SIGTERM);
  const bool ended = run.robot.AwaitControllerEnd(2 * Milliseconds(kShutdownBudgetMs));
  if (ended) run.RecoveredNow();
  link.LinkUp(false);
  run.Expect(ended, "without a network the controller does not end in twice its budget");
}

void KilledFarAway(FaultRun& run) {
  const std::string victim = run.Victim({"arm", "eyes", "hands"});
  const pid_t pid = run.robot.PidOf(victim);
  run.Struck();
  kill(pid, SIGKILL);
  run.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  run.RecoveredIn(run.state());
}

}  // namespace musher::fault_injection::network
