// The controller's disk does not answer: what writes to it waits. The loop waits for nothing.

#include <signal.h>

#include <algorithm>

#include "musher/test/fault_injection/faults/expectation.hpp"
#include "musher/test/fault_injection/faults/resource.hpp"

namespace musher::fault_injection::resource {
namespace {

// Longer than an actuator goes without a controller, and than systemd waits for a sign of life.
constexpr Duration kLongStall = std::chrono::seconds(12);
// In which everything that does not need the disk has to be done.
constexpr Duration kPrompt = std::chrono::seconds(2);
// What a controller that ends gives the disk and DDS beyond its budget.
constexpr Duration kLastWords = std::chrono::seconds(5);

// A controller on such a disk leads, and the disk stalls from now on until this is over.
class Stall {
 public:
  explicit Stall(FaultRun& run) : run_(run) {
    run.ControllerMayDie();
    run.robot.KillController();
    run.robot.StartController({}, Robot::Disk::kMayStall);
    run.Require(run.robot.AwaitSettled(run.state()), "no controller adopts the robot");
    run.robot.ForgetLines();
    run.robot.StallDisk(true);
    run.Struck();
  }
  ~Stall() { run_.robot.StallDisk(false); }
  Stall(const Stall&) = delete;
  Stall& operator=(const Stall&) = delete;

  void End() {
    run_.robot.StallDisk(false);
    const auto saved = [](const msg::MachineStatus& status) { return status.not_on_disk.empty(); };
    run_.Require(run_.observer().Await(saved, kPatience).has_value(),
                 "the status names something that is not on disk on a disk that works");
  }

 private:
  FaultRun& run_;
};

bool AllHaveLatched(FaultRun& run, bool engaged) {
  const auto said = run.observer().LatestOfActuators();
  return std::all_of(said.begin(), said.end(), [engaged](const auto& actuator) {
    return (actuator.second.emergency_stop != 0) == engaged;
  });
}

bool IsUnsaved(const msg::MachineStatus& status, const std::string& what) {
  return std::any_of(status.not_on_disk.begin(), status.not_on_disk.end(),
                     [&](const std::string& entry) { return entry.starts_with(what); });
}

// The controller answers all the time, and no actuator is without it.
void MustAnswerFor(FaultRun& run, Duration time) {
  const Time end = std::chrono::steady_clock::now() + time;
  Duration longest{};
  while (std::chrono::steady_clock::now() < end) {
    const Time asked = std::chrono::steady_clock::now();
    const auto status = run.observer().GetStatus();
    run.Require(status.ok(), "the controller does not answer");
    longest = std::max(longest, std::chrono::steady_clock::now() - asked);
    run.LetPass(Milliseconds(20));
  }
  run.Expect(longest < kPrompt,
             "an answer took " + std::to_string(ToMilliseconds(longest)) + " ms");
}

}  // namespace

void DiskStallsAndStops(FaultRun& run) {
  if (run.state() == "Active") run.MoveTo("DeActive");
  Stall stall(run);
  // 1: the ROS 2 node knows no emergency stop, which is told.
  run.Expect(run.robot.Musher({"estop", "the disk stalls"}) == 1, "musher estop fails");
  run.Require(AwaitThat([&] { return AllHaveLatched(run, true); }, kPrompt),
              "not all have latched the stop");
  run.DetectedNow();
  const auto is_told = [](const auto& s) { return s.emergency_stop && IsUnsaved(s, "emergency"); };
  run.Require(run.observer().AwaitSince(run.struck(), is_told, kPatience).has_value(),
              "the status does not say that the emergency stop is not on disk");
  const auto refused = Answer(run.observer().SetState("Active"));
  run.ExpectOutcome(refused, "refused");
  run.Struck(FaultRun::Clock::kRecovery);
  stall.End();
  run.RecoveredIn(run.state());
  run.Expect(std::filesystem::exists(run.robot.StateFolder() / "emergency_stop"),
             "the emergency stop is not on disk");
  const auto released = run.observer().ReleaseEmergencyStop();
  run.Require(released.ok() && released.value().code == 0, "the stop cannot be released");
  run.Require(AwaitThat([&] { return AllHaveLatched(run, false); }, kPatience),
              "not all have released the stop");
}

void DiskStallsInSwitch(FaultRun& run) {
  Stall stall(run);
  const std::string target = run.state() == "DeActive" ? "LowPower" : "DeActive";
  run.MayBecome(target);
  const Time asked = std::chrono::steady_clock::now();
  run.ExpectOutcome(Answer(run.observer().SetState(target)), "done");
  run.Expect(std::chrono::steady_clock::now() - asked < kPrompt,
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
  MustAnswerFor(run, kLongStall);
  run.Require(!run.robot.ControllerHasEnded(), "the controller has ended");
  run.Struck(FaultRun::Clock::kRecovery);
  stall.End();
  run.RecoveredIn(run.state());
}

void DiskStallsAndTearsDown(FaultRun& run) {
  Stall stall(run);
  run.RobotIsTornDown();
  run.ExpectOutcome(Answer(run.observer().SetState("TearDown")), "done");
  run.DetectedNow();
  run.Require(run.robot.AwaitControllerEnd(kPatience), "the machine does not end");
  run.RecoveredNow();
  const Duration allowed = Milliseconds(kShutdownBudgetMs) + kLastWords;
  run.Expect(std::chrono::steady_clock::now() - run.struck() < allowed,
             "the controller has waited for the disk for too long");
}

}  // namespace musher::fault_injection::resource
