// The controller's disk: full, limited, gone, or read only. The robot goes on without it.

#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <fstream>

#include "musher/test/fault_injection/faults/expectation.hpp"
#include "musher/test/fault_injection/faults/resource.hpp"
#include "musher/test/fault_injection/host/isolation.hpp"

namespace musher::fault_injection::resource {
namespace {

namespace fs = std::filesystem;

// Whatever the disk does, a robot switches, and one that dies comes back.
void MustGoOn(FaultRun& run) {
  const std::string target = run.state() == "DeActive" ? "LowPower" : "DeActive";
  run.MayBecome(target);
  run.ExpectOutcome(Answer(run.observer().SetState(target)), "done");
  const std::string victim = run.Victim({"legs", "arm", "eyes", "hands", "voice"});
  kill(run.robot.PidOf(victim), SIGKILL);
  run.Require(
      run.observer().AwaitSince(run.struck(), IsKnownAs(victim, "crashed"), kPatience).has_value(),
      "the status never tells that " + victim + " has crashed");
  run.RecoveredIn(target);
}

// The controller says what is wrong, and that once.
void MustSaySoOnce(FaultRun& run) {
  run.Require(AwaitThat([&] { return run.robot.CountLines("trouble") > 0; }, kPatience),
              "the controller says nothing of its trouble");
  if (!run.outcome.detection_ms) run.DetectedNow();
}

void MustNotHaveRepeatedItself(FaultRun& run) {
  const int said = run.robot.CountLines("trouble");
  run.Expect(said <= 2,
             "the controller has told of its trouble " + std::to_string(said) + " times");
}

// Another controller, which finds all as it should be.
void RestartController(FaultRun& run) {
  const std::string state = run.observer().Latest()->state;
  run.robot.KillController();
  run.robot.StartController();
  run.Require(run.robot.AwaitSettled(state), "the next controller does not adopt the robot");
}

}  // namespace

void DiskIsFull(FaultRun& run) {
  const fs::path ballast = run.robot.folder() / "disk" / "ballast";
  run.ControllerMayDie();
  run.Struck();
  {
    std::ofstream file(ballast);
    const std::string block(4096, 'x');
    while (file.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
    }
  }
  (void)Answer(run.observer().SetState("SelfCheck"));  // something to write down
  MustSaySoOnce(run);
  MustGoOn(run);
  MustNotHaveRepeatedItself(run);
  fs::remove(ballast);
  RestartController(run);
}

void FileSizeIsLimited(FaultRun& run) {
  const rlimit limit{1, RLIM_INFINITY};
  run.ControllerMayDie();
  run.Require(prlimit(run.robot.LivingController(), RLIMIT_FSIZE, &limit, nullptr) == 0,
              "prlimit(RLIMIT_FSIZE)");
  run.Struck();
  (void)Answer(run.observer().SetState("SelfCheck"));
  run.Require(!run.robot.ControllerHasEnded(), "the controller died of a file that is limited");
  MustSaySoOnce(run);
  MustGoOn(run);
  MustNotHaveRepeatedItself(run);
  RestartController(run);
}

void FilesAreLimited(FaultRun& run) {
  const pid_t controller = run.robot.LivingController();
  rlimit before{};
  prlimit(controller, RLIMIT_NOFILE, nullptr, &before);
  const rlimit none{3, before.rlim_max};
  run.Require(prlimit(controller, RLIMIT_NOFILE, &none, nullptr) == 0, "prlimit(RLIMIT_NOFILE)");
  const std::string victim = run.Victim({"arm", "eyes", "hands"});
  run.Struck();
  kill(run.robot.PidOf(victim), SIGKILL);
  run.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  const std::string target = run.state() == "DeActive" ? "LowPower" : "DeActive";
  run.MayBecome(target);
  const auto answer = Answer(run.observer().SetState(target));
  run.Expect(answer.ok(), "no answer without file descriptors");
  prlimit(controller, RLIMIT_NOFILE, &before, nullptr);
  if (!run.observer().Await([&](const auto& s) { return IsSettled(s, target); },
                            Milliseconds(1500))) {
    (void)run.observer().Restart(victim);  // it was given up meanwhile
  }
  run.RecoveredIn(target);
}

void StateFolderVanishes(FaultRun& run) {
  run.ControllerMayDie();
  run.Struck();
  fs::remove_all(run.robot.StateFolder());
  MustGoOn(run);
  RestartController(run);
  run.Expect(fs::exists(run.robot.StateFolder() / "epoch"),
             "the next controller has not made its folder anew");
}

void StateFolderIsReadOnly(FaultRun& run) {
  const fs::path disk = run.robot.folder() / "disk";
  run.ControllerMayDie();
  const std::string state = run.state();
  run.robot.KillController();
  MountMemory(disk, 64);
  MakeReadOnly(disk, true);
  run.robot.ForgetLines();
  run.Struck();
  run.robot.StartController();
  const bool adopted = run.robot.AwaitSettled(state);
  if (adopted) run.RecoveredNow();
  if (adopted) {
    MustSaySoOnce(run);
    MustGoOn(run);
    MustNotHaveRepeatedItself(run);
    run.robot.KillController();
  }
  umount2(disk.c_str(), MNT_DETACH);
  run.Require(adopted, "without a state folder no controller adopts the robot");
  run.robot.StartController();
  run.Require(run.robot.AwaitSettled(run.observer().Latest()->state),
              "the next controller does not adopt the robot");
}

}  // namespace musher::fault_injection::resource
