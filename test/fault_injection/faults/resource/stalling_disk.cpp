// The controller's disk stalls: its writers wait, its event loop does not.

#include <signal.h>

#include <algorithm>

#include "musher/test/fault_injection/faults/expectation.hpp"
#include "musher/test/fault_injection/faults/resource.hpp"

namespace musher::fault_injection::resource {
namespace {

// Longer than controller_lost_ms of the actuators, and than systemd's watchdog.
constexpr Duration kLongStall = std::chrono::seconds(12);
// Everything that does not need the disk must be done within this.
constexpr Duration kPrompt = std::chrono::seconds(2);
// How much longer than its budget a controller waits for the disk and DDS when it ends.
constexpr Duration kExitGrace = std::chrono::seconds(5);

// Starts a controller on such a disk, and stalls the disk until End().
class Stall {
 public:
  explicit Stall(FaultRun& run) : run_(run) {
    run.ControllerMayDie();
    run.robot.KillController();
    run.robot.StartController({}, Robot::Disk::kMayStall);
    run.Require(run.robot.AwaitSettled(run.state()), "no controller adopts the robot");
    run.robot.ForgetLines();
    run.robot.StallDisk(true);
    run.FaultInjected();
  }
  ~Stall() { run_.robot.StallDisk(false); }
  Stall(const Stall&) = delete;
  Stall& operator=(const Stall&) = delete;

  void End() {
    run_.robot.StallDisk(false);
    const auto saved = [](const msg::MachineStatus& status) { return status.not_on_disk.empty(); };
    run_.Require(run_.observer().Await(saved, kTimeout).has_value(),
                 "the status reports unsaved state although the disk works");
  }

 private:
  FaultRun& run_;
};

bool AllHaveLatched(FaultRun& run, bool engaged) {
  const auto reports = run.observer().LatestOfActuators();
  return std::all_of(reports.begin(), reports.end(), [engaged](const auto& actuator) {
    return (actuator.second.emergency_stop != 0) == engaged;
  });
}

bool IsUnsaved(const msg::MachineStatus& status, const std::string& what) {
  return std::any_of(status.not_on_disk.begin(), status.not_on_disk.end(),
                     [&](const std::string& entry) { return entry.starts_with(what); });
}

// The controller replies all the time, and the actuators keep receiving its heartbeats.
void MustReplyFor(FaultRun& run, Duration time) {
  const Time end = std::chrono::steady_clock::now() + time;
  Duration longest{};
  while (std::chrono::steady_clock::now() < end) {
    const Time requested_at = std::chrono::steady_clock::now();
    const auto status = run.observer().GetStatus();
    run.Require(status.ok(), "the controller does not reply");
    longest = std::max(longest, std::chrono::steady_clock::now() - requested_at);
    run.LetPass(Milliseconds(20));
  }
  run.Expect(longest < kPrompt, "a reply took " + std::to_string(ToMilliseconds(longest)) + " ms");
}

}  // namespace

void DiskStallsAndStops(FaultRun& run) {
  if (run.state() == "Active") run.MoveTo("DeActive");
  Stall stall(run);
  // Exit code 1: the ROS 2 node has no emergency stop, which the command reports.
  run.Expect(run.robot.Musher({"estop", "the disk stalls"}) == 1, "musher estop fails");
  run.Require(AwaitThat([&] { return AllHaveLatched(run, true); }, kPrompt),
              "not all have latched the stop");
  run.DetectedNow();
  const auto is_reported = [](const auto& s) {
    return s.emergency_stop && IsUnsaved(s, "emergency");
  };
  run.Require(run.observer().AwaitSince(run.injected_at(), is_reported, kTimeout).has_value(),
              "the status does not report the emergency stop as unsaved");
  const auto refused = AwaitFuture(run.observer().SetState("Active"));
  run.ExpectOutcome(refused, "refused");
  run.FaultInjected(FaultRun::Clock::kRecovery);
  stall.End();
  run.RecoveredIn(run.state());
  run.Expect(std::filesystem::exists(run.robot.StateFolder() / "emergency_stop"),
             "the emergency stop is not on disk");
  const auto released = run.observer().ReleaseEmergencyStop();
  run.Require(released.ok() && released.value().code == 0, "the stop cannot be released");
  run.Require(AwaitThat([&] { return AllHaveLatched(run, false); }, kTimeout),
              "not all have released the stop");
}

void DiskStallsInSwitch(FaultRun& run) {
  Stall stall(run);
  const std::string target = run.state() == "DeActive" ? "LowPower" : "DeActive";
  run.MayBecome(target);
  const Time requested_at = std::chrono::steady_clock::now();
  run.ExpectOutcome(AwaitFuture(run.observer().SetState(target)), "done");
  run.Expect(std::chrono::steady_clock::now() - requested_at < kPrompt,
             "the switch has waited for the disk");
  run.RecoveredIn(target);
  stall.End();
}

void DiskStallsAndKills(FaultRun& run) {
  Stall stall(run);
  const std::string victim = run.Victim({"legs", "arm", "eyes", "hands", "voice"});
  kill(run.robot.PidOf(victim), SIGKILL);
  run.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  run.RecoveredIn(run.state());
  stall.End();
}

void DiskStallsForLong(FaultRun& run) {
  Stall stall(run);
  MustReplyFor(run, kLongStall);
  run.Require(!run.robot.ControllerHasEnded(), "the controller has ended");
  run.FaultInjected(FaultRun::Clock::kRecovery);
  stall.End();
  run.RecoveredIn(run.state());
}

void DiskStallsAndTearsDown(FaultRun& run) {
  Stall stall(run);
  run.RobotIsTornDown();
  run.ExpectOutcome(AwaitFuture(run.observer().SetState("TearDown")), "done");
  run.DetectedNow();
  run.Require(run.robot.AwaitControllerEnd(kTimeout), "the machine does not end");
  run.RecoveredNow();
  const Duration allowed = Milliseconds(kShutdownBudgetMs) + kExitGrace;
  run.Expect(std::chrono::steady_clock::now() - run.injected_at() < allowed,
             "the controller has waited for the disk for too long");
}

}  // namespace musher::fault_injection::resource
