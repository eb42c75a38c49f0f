// The controller's disk: full, limited, gone, or read only. The robot goes on without it.

#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <fstream>

#include "musher/test/campaign/faults/promise.hpp"
#include "musher/test/campaign/faults/resource.hpp"
#include "musher/test/campaign/host/isolation.hpp"

namespace musher::campaign::resource {
namespace {

namespace fs = std::filesystem;

// Whatever the disk does, a robot switches, and one that dies comes back.
void MustGoOn(Trial& trial) {
  const std::string target = trial.state() == "DeActive" ? "LowPower" : "DeActive";
  trial.MayBecome(target);
  trial.ExpectOutcome(Answer(trial.observer().SetState(target)), "done");
  const std::string victim = trial.Victim({"legs", "arm", "eyes", "hands", "voice"});
  kill(trial.robot.PidOf(victim), SIGKILL);
  trial.Require(trial.observer()
                    .AwaitSince(trial.struck(), IsKnownAs(victim, "crashed"), kPatience)
                    .has_value(),
                "the status never tells that " + victim + " has crashed");
  trial.RecoveredIn(target);
}

// The controller says what is wrong, and that once.
void MustSaySoOnce(Trial& trial) {
  trial.Require(AwaitThat([&] { return trial.robot.CountLines("trouble") > 0; }, kPatience),
                "the controller says nothing of its trouble");
  if (!trial.outcome.detection_ms) trial.DetectedNow();
}

void MustNotHaveRepeatedItself(Trial& trial) {
  const int said = trial.robot.CountLines("trouble");
  trial.Expect(said <= 2,
               "the controller has told of its trouble " + std::to_string(said) + " times");
}

// Another controller, which finds all as it should be.
void RestartController(Trial& trial) {
  const std::string state = trial.observer().Latest()->state;
  trial.robot.KillController();
  trial.robot.StartController();
  trial.Require(trial.robot.AwaitSettled(state), "the next controller does not adopt the robot");
}

}  // namespace

void DiskIsFull(Trial& trial) {
  const fs::path ballast = trial.robot.folder() / "disk" / "ballast";
  trial.ControllerMayDie();
  trial.Struck();
  {
    std::ofstream file(ballast);
    const std::string block(4096, 'x');
    while (file.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
    }
  }
  (void)Answer(trial.observer().SetState("SelfCheck"));  // something to write down
  MustSaySoOnce(trial);
  MustGoOn(trial);
  MustNotHaveRepeatedItself(trial);
  fs::remove(ballast);
  RestartController(trial);
}

void FileSizeIsLimited(Trial& trial) {
  const rlimit limit{1, RLIM_INFINITY};
  trial.ControllerMayDie();
  trial.Require(prlimit(trial.robot.ControllerPid(), RLIMIT_FSIZE, &limit, nullptr) == 0,
                "prlimit(RLIMIT_FSIZE)");
  trial.Struck();
  (void)Answer(trial.observer().SetState("SelfCheck"));
  trial.Require(!trial.robot.ControllerHasEnded(), "the controller died of a file that is limited");
  MustSaySoOnce(trial);
  MustGoOn(trial);
  MustNotHaveRepeatedItself(trial);
  RestartController(trial);
}

void FilesAreLimited(Trial& trial) {
  const pid_t controller = trial.robot.ControllerPid();
  rlimit before{};
  prlimit(controller, RLIMIT_NOFILE, nullptr, &before);
  const rlimit none{3, before.rlim_max};
  trial.Require(prlimit(controller, RLIMIT_NOFILE, &none, nullptr) == 0, "prlimit(RLIMIT_NOFILE)");
  const std::string victim = trial.Victim({"arm", "eyes", "hands"});
  trial.Struck();
  kill(trial.robot.PidOf(victim), SIGKILL);
  trial.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  const std::string target = trial.state() == "DeActive" ? "LowPower" : "DeActive";
  trial.MayBecome(target);
  const auto answer = Answer(trial.observer().SetState(target));
  trial.Expect(answer.ok(), "no answer without file descriptors");
  prlimit(controller, RLIMIT_NOFILE, &before, nullptr);
  if (!trial.observer().Await([&](const auto& s) { return IsSettled(s, target); },
                              Milliseconds(1500))) {
    (void)trial.observer().Restart(victim);  // it was given up meanwhile
  }
  trial.RecoveredIn(target);
}

void StateFolderVanishes(Trial& trial) {
  trial.ControllerMayDie();
  trial.Struck();
  fs::remove_all(trial.robot.StateFolder());
  MustGoOn(trial);
  RestartController(trial);
  trial.Expect(fs::exists(trial.robot.StateFolder() / "epoch"),
               "the next controller has not made its folder anew");
}

void StateFolderIsReadOnly(Trial& trial) {
  const fs::path disk = trial.robot.folder() / "disk";
  trial.ControllerMayDie();
  const std::string state = trial.state();
  trial.robot.KillController();
  MountMemory(disk, 64);
  MakeReadOnly(disk, true);
  trial.robot.ForgetLines();
  trial.Struck();
  trial.robot.StartController();
  const bool adopted = trial.robot.AwaitSettled(state);
  if (adopted) trial.RecoveredNow();
  if (adopted) {
    MustSaySoOnce(trial);
    MustGoOn(trial);
    MustNotHaveRepeatedItself(trial);
    trial.robot.KillController();
  }
  umount2(disk.c_str(), MNT_DETACH);
  trial.Require(adopted, "without a state folder no controller adopts the robot");
  trial.robot.StartController();
  trial.Require(trial.robot.AwaitSettled(trial.observer().Latest()->state),
                "the next controller does not adopt the robot");
}

}  // namespace musher::campaign::resource
