// The other host reboots, or has a controller of its own.

#include <algorithm>

#include "musher/test/fault_injection/faults/network.hpp"

namespace musher::fault_injection::network {
namespace {

// More than the processes of an actuator that a controller remembers.
constexpr int kReboots = 5;
// Longer than the starts in a row are counted.
constexpr Duration kRest = Milliseconds(500);

const LinkImpairment kDeaf{100, 0, {}, {}};

Time Now() {
  return std::chrono::steady_clock::now();
}

int StartsOf(FaultRun& run) {
  int starts = 0;
  for (const std::string& name : Modules()) starts += run.robot.board(name).starts;
  return starts;
}

bool ActuatorIsMissing(const msg::MachineStatus& status) {
  return std::any_of(status.actuators.begin(), status.actuators.end(),
                     [](const auto& info) { return info.presence != "present"; });
}

// Whether each actuator has another process than in `before`: a process that ended with its host
// counts as present until its heartbeat is lost.
bool AllAreOtherProcesses(const msg::MachineStatus& status, const msg::MachineStatus& before) {
  return std::all_of(status.actuators.begin(), status.actuators.end(),
                     [&](const auto& info) { return info.pid != Find(before, info.name).pid; });
}

}  // namespace

void IsRebooted(FaultRun& run) {
  run.MayAllBeAffected();
  const int before = RankOf(run.state());
  for (int i = 0; i < kReboots; ++i) {
    const Time at = Now();
    const msg::MachineStatus last = *run.observer().Latest();
    if (i == 0) run.FaultInjected();
    run.robot.far_host()->Reboot();
    const std::string which = "after reboot " + std::to_string(i + 1);
    // The new processes may be there when their predecessors are seen to be gone.
    const auto is_seen = [&last](const auto& status) {
      return ActuatorIsMissing(status) || AllAreOtherProcesses(status, last);
    };
    if (i == 0) run.Detected("the actuators are missing, or other processes", is_seen);
    run.Require(run.observer().AwaitSince(at, is_seen, kTimeout).has_value(),
                "no actuator is missing " + which);
    run.Recovered("settled " + which, [before, &last](const auto& status) {
      const int rank = RankOf(status.state);
      return rank >= 0 && rank <= before && IsSettled(status, status.state) &&
             AllAreOtherProcesses(status, last);
    });
    run.LetPass(kRest);
  }
}

void IsTakenOverFromThere(FaultRun& run, bool deaf) {
  run.ControllerMayDie();
  run.MayAllBeAffected();
  const auto before = run.observer().Latest();
  const int starts = StartsOf(run);
  Link& link = run.robot.far_host()->link();
  run.FaultInjected();
  if (deaf) link.Set(kDeaf, {}, 0);
  benchmark::Child there = run.robot.StartFarController({"--takeover"});
  if (deaf) {
    const auto led = [&] {
      const auto reports = run.observer().LatestOfActuators();
      return std::any_of(reports.begin(), reports.end(), [&](const auto& actuator) {
        return actuator.second.epoch > before->epoch;
      });
    };
    // This host may or may not receive their new epoch.
    static_cast<void>(AwaitThat(led, std::chrono::seconds(4)));
    link.Heal();
  }
  const int first = run.robot.AwaitEndOfFirst();
  run.Expect(first == 1, "the first controller ends with " + std::to_string(first) + ", not 1");
  run.DetectedNow();
  run.Recovered("led from the other host", [&](const auto& status) {
    return status.host != before->host && status.epoch > before->epoch &&
           RankOf(status.state) <= RankOf(before->state) && IsSettled(status, status.state);
  });
  run.Expect(StartsOf(run) == starts, "the takeover restarted modules");
  run.robot.StartController({"--takeover"});
  run.Expect(there.Wait() == 1, "the controller of the other host does not release control");
  run.Require(run.robot.AwaitSettled(), "the controller here does not take over again");
}

void IsReplacedByStandby(FaultRun& run, bool killed) {
  constexpr Duration kShort = Milliseconds(1000);  // failover_ms is 3000
  run.ControllerMayDie();
  run.MayAllBeAffected();
  Robot& robot = run.robot;
  const int starts = StartsOf(run);
  benchmark::Child there = robot.StartFarController({"--standby"});
  run.Require(AwaitThat([&] { return !robot.TimeOfFarLine("stands by").empty(); }, kTimeout),
              "the other host does not stand by");
  const auto before = run.observer().Latest();
  Link& link = robot.far_host()->link();
  link.Set(kDeaf, kDeaf, 0);
  run.LetPass(kShort);
  link.Heal();
  run.LetPass(kShort);
  run.Expect(robot.TimeOfFarLine("controller started").empty(), "it leads after a short cut");
  run.FaultInjected();
  if (killed) {
    robot.KillController();
  } else {
    link.Set(kDeaf, kDeaf, 0);
    const int first = robot.AwaitEndOfFirst();
    run.Expect(first == 1, "the first controller ends with " + std::to_string(first) + ", not 1");
  }
  run.DetectedNow();
  const auto leads = [&] { return !robot.TimeOfFarLine("this standby leads now").empty(); };
  run.Require(AwaitThat(leads, kTimeout), "the standby does not lead");
  const std::string released = robot.TimeOfLine("releases control");
  run.Expect(killed || (!released.empty() && released < robot.TimeOfFarLine("controller started")),
             "the first controller has released control at '" + released + "'");
  link.Heal();
  run.Recovered("led from the other host", [&](const auto& status) {
    return status.host != before->host && status.epoch > before->epoch &&
           RankOf(status.state) <= RankOf(before->state) && IsSettled(status, status.state);
  });
  run.Expect(StartsOf(run) == starts, "the fail-over restarted modules");
  robot.StartController({"--takeover"});
  run.Expect(there.Wait() == 1, "the controller of the other host does not release control");
  run.Require(robot.AwaitSettled(), "the controller here does not take over again");
}

}  // namespace musher::fault_injection::network
