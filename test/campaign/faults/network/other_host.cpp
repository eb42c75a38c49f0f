// The other host is started again, or has a controller of its own.

#include <algorithm>

#include "musher/test/campaign/faults/network.hpp"

namespace musher::campaign::network {
namespace {

// More often than a controller remembers processes of an actuator.
constexpr int kReboots = 5;
// Longer than starts in a row are counted.
constexpr Duration kRest = Milliseconds(500);

const Weather kDeaf{100, 0, {}, {}};

Time Now() {
  return std::chrono::steady_clock::now();
}

int StartsOf(Trial& trial) {
  int starts = 0;
  for (const std::string& name : Modules()) starts += trial.robot.board(name).starts;
  return starts;
}

bool ActuatorIsMissing(const msg::MachineStatus& status) {
  return std::any_of(status.actuators.begin(), status.actuators.end(),
                     [](const auto& info) { return info.presence != "present"; });
}

// Whether each actuator answers from another process than in `before`: one whose process died with
// its host passes for present until its silence is noticed.
bool AllAreOtherProcesses(const msg::MachineStatus& status, const msg::MachineStatus& before) {
  return std::all_of(status.actuators.begin(), status.actuators.end(),
                     [&](const auto& info) { return info.pid != Find(before, info.name).pid; });
}

}  // namespace

void IsRebooted(Trial& trial) {
  trial.MayAllBeHurt();
  const int before = RankOf(trial.state());
  for (int i = 0; i < kReboots; ++i) {
    const Time at = Now();
    const msg::MachineStatus last = *trial.observer().Latest();
    if (i == 0) trial.Struck();
    trial.robot.far_host()->Reboot();
    const std::string which = "after reboot " + std::to_string(i + 1);
    if (i == 0) trial.Detected("the actuators are missed", ActuatorIsMissing);
    trial.Require(trial.observer().AwaitSince(at, ActuatorIsMissing, kPatience).has_value(),
                  "no actuator is missed " + which);
    trial.Recovered("settled " + which, [before, &last](const auto& status) {
      const int rank = RankOf(status.state);
      return rank >= 0 && rank <= before && IsSettled(status, status.state) &&
             AllAreOtherProcesses(status, last);
    });
    trial.LetPass(kRest);
  }
}

void IsTakenOverFromThere(Trial& trial, bool deaf) {
  trial.ControllerMayDie();
  trial.MayAllBeHurt();
  const auto before = trial.observer().Latest();
  const int starts = StartsOf(trial);
  Cable& cable = trial.robot.far_host()->cable();
  trial.Struck();
  if (deaf) cable.Set(kDeaf, {}, 0);
  benchmark::Child there = trial.robot.StartFarController({"--takeover"});
  if (deaf) {
    const auto led = [&] {
      const auto said = trial.observer().LatestOfActuators();
      return std::any_of(said.begin(), said.end(), [&](const auto& actuator) {
        return actuator.second.epoch > before->epoch;
      });
    };
    // Whether it is heard over here that they follow another is the network's to say.
    static_cast<void>(AwaitThat(led, std::chrono::seconds(4)));
    cable.Heal();
  }
  const int first = trial.robot.AwaitEndOfFirst();
  trial.Expect(first == 1, "the first controller ends with " + std::to_string(first) + ", not 1");
  trial.DetectedNow();
  trial.Recovered("led from the other host", [&](const auto& status) {
    return status.host != before->host && status.epoch > before->epoch &&
           RankOf(status.state) <= RankOf(before->state) && IsSettled(status, status.state);
  });
  trial.Expect(StartsOf(trial) == starts, "modules were started again by the take-over");
  trial.robot.StartController({"--takeover"});
  trial.Expect(there.Wait() == 1, "the controller of the other host does not let go");
  trial.Require(trial.robot.AwaitSettled(), "the machine is not taken back");
}

}  // namespace musher::campaign::network
