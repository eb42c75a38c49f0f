// The controller's disk does not answer: what writes to it waits. The loop waits for nothing.

#include <signal.h>

#include <algorithm>

#include "musher/test/campaign/faults/promise.hpp"
#include "musher/test/campaign/faults/resource.hpp"

namespace musher::campaign::resource {
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
  explicit Stall(Trial& trial) : trial_(trial) {
    trial.ControllerMayDie();
    trial.robot.KillController();
    trial.robot.StartController({}, Robot::Disk::kMayStall);
    trial.Require(trial.robot.AwaitSettled(trial.state()), "no controller adopts the robot");
    trial.robot.ForgetLines();
    trial.robot.StallDisk(true);
    trial.Struck();
  }
  ~Stall() { trial_.robot.StallDisk(false); }
  Stall(const Stall&) = delete;
  Stall& operator=(const Stall&) = delete;

  void End() {
    trial_.robot.StallDisk(false);
    const auto saved = [](const msg::MachineStatus& status) { return status.not_on_disk.empty(); };
    trial_.Require(trial_.observer().Await(saved, kPatience).has_value(),
                   "the status names something that is not on disk on a disk that works");
  }

 private:
  Trial& trial_;
};

bool AllHaveLatched(Trial& trial, bool engaged) {
  const auto said = trial.observer().LatestOfActuators();
  return std::all_of(said.begin(), said.end(), [engaged](const auto& actuator) {
    return (actuator.second.emergency_stop != 0) == engaged;
  });
}

bool IsUnsaved(const msg::MachineStatus& status, const std::string& what) {
  return std::any_of(status.not_on_disk.begin(), status.not_on_disk.end(),
                     [&](const std::string& entry) { return entry.starts_with(what); });
}

// The controller answers all the time, and no actuator is without it.
void MustAnswerFor(Trial& trial, Duration time) {
  const Time end = std::chrono::steady_clock::now() + time;
  Duration longest{};
  while (std::chrono::steady_clock::now() < end) {
    const Time asked = std::chrono::steady_clock::now();
    const auto status = trial.observer().GetStatus();
    trial.Require(status.ok(), "the controller does not answer");
    longest = std::max(longest, std::chrono::steady_clock::now() - asked);
    trial.LetPass(Milliseconds(20));
  }
  trial.Expect(longest < kPrompt,
               "an answer took " + std::to_string(ToMilliseconds(longest)) + " ms");
}

}  // namespace

void DiskStallsAndStops(Trial& trial) {
  if (trial.state() == "Active") trial.MoveTo("DeActive");
  Stall stall(trial);
  trial.Expect(trial.robot.Musher({"estop", "the disk stalls"}) == 0, "musher estop fails");
  trial.Require(AwaitThat([&] { return AllHaveLatched(trial, true); }, kPrompt),
                "not all have latched the stop");
  trial.DetectedNow();
  const auto is_told = [](const auto& s) { return s.emergency_stop && IsUnsaved(s, "emergency"); };
  trial.Require(trial.observer().AwaitSince(trial.struck(), is_told, kPatience).has_value(),
                "the status does not say that the emergency stop is not on disk");
  const auto refused = Answer(trial.observer().SetState("Active"));
  trial.ExpectOutcome(refused, "refused");
  trial.Struck(Trial::Clock::kRecovery);
  stall.End();
  trial.RecoveredIn(trial.state());
  trial.Expect(std::filesystem::exists(trial.robot.StateFolder() / "emergency_stop"),
               "the emergency stop is not on disk");
  const auto released = trial.observer().ReleaseEmergencyStop();
  trial.Require(released.ok() && released.value().code == 0, "the stop cannot be released");
  trial.Require(AwaitThat([&] { return AllHaveLatched(trial, false); }, kPatience),
                "not all have released the stop");
}

void DiskStallsInSwitch(Trial& trial) {
  Stall stall(trial);
  const std::string target = trial.state() == "DeActive" ? "LowPower" : "DeActive";
  trial.MayBecome(target);
  const Time asked = std::chrono::steady_clock::now();
  trial.ExpectOutcome(Answer(trial.observer().SetState(target)), "done");
  trial.Expect(std::chrono::steady_clock::now() - asked < kPrompt,
               "the switch has waited for the disk");
  trial.RecoveredIn(target);
  stall.End();
}

void DiskStallsAndKills(Trial& trial) {
  Stall stall(trial);
  const std::string victim = trial.Victim({"legs", "arm", "eyes", "hands", "voice"});
  kill(trial.robot.PidOf(victim), SIGKILL);
  trial.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  trial.RecoveredIn(trial.state());
  stall.End();
}

void DiskStallsForLong(Trial& trial) {
  Stall stall(trial);
  MustAnswerFor(trial, kLongStall);
  trial.Require(!trial.robot.ControllerHasEnded(), "the controller has ended");
  trial.Struck(Trial::Clock::kRecovery);
  stall.End();
  trial.RecoveredIn(trial.state());
}

void DiskStallsAndTearsDown(Trial& trial) {
  Stall stall(trial);
  trial.RobotIsTornDown();
  trial.ExpectOutcome(Answer(trial.observer().SetState("TearDown")), "done");
  trial.DetectedNow();
  trial.Require(trial.robot.AwaitControllerEnd(kPatience), "the machine does not end");
  trial.RecoveredNow();
  const Duration allowed = Milliseconds(kShutdownBudgetMs) + kLastWords;
  trial.Expect(std::chrono::steady_clock::now() - trial.struck() < allowed,
               "the controller has waited for the disk for too long");
}

}  // namespace musher::campaign::resource
