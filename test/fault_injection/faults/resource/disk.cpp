// The controller's disk: full, limited, removed, or read-only. The robot works without it.

#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <algorithm>
#include <fstream>

#include "musher/test/fault_injection/faults/expectation.hpp"
#include "musher/test/fault_injection/faults/resource.hpp"
#include "musher/test/fault_injection/host/isolation.hpp"

namespace musher::fault_injection::resource {
namespace {

namespace fs = std::filesystem;

// With any fault of the disk the robot switches, and restarts a killed actuator.
void MustKeepWorking(FaultRun& run) {
  const std::string target = run.state() == "DeActive" ? "LowPower" : "DeActive";
  run.MayBecome(target);
  run.ExpectOutcome(AwaitFuture(run.observer().SetState(target)), "done");
  const std::string victim = run.Victim({"legs", "arm", "eyes", "hands", "voice"});
  kill(run.robot.PidOf(victim), SIGKILL);
  run.Require(run.observer()
                  .AwaitSince(run.injected_at(), IsKnownAs(victim, "crashed"), kTimeout)
                  .has_value(),
              "the status never reports that " + victim + " has crashed");
  run.RecoveredIn(target);
}

int ReportsOfTheJournal(FaultRun& run) {
  return run.robot.CountLines("machine", "the journal is not on disk");
}

// The controller reports that its journal lacks entries, once; the status shows it.
void MustReportTheJournal(FaultRun& run) {
  run.Require(AwaitThat([&] { return ReportsOfTheJournal(run) > 0; }, kTimeout),
              "the controller does not report that the journal is not on disk");
  if (!run.outcome.detection_ms) run.DetectedNow();
  const auto shows = [](const msg::MachineStatus& status) {
    return std::ranges::any_of(status.not_on_disk,
                               [](const auto& what) { return what.starts_with("journal"); });
  };
  run.Require(run.observer().Await(shows, kTimeout).has_value(),
              "the status does not show that the journal is not on disk");
}

void MustNotRepeatTheReport(FaultRun& run) {
  const int count = ReportsOfTheJournal(run);
  run.Expect(count <= 2,
             "the controller has reported the journal " + std::to_string(count) + " times");
}

// Starts the next controller, which adopts the settled robot.
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
  run.FaultInjected();
  {
    std::ofstream file(ballast);
    const std::string block(4096, 'x');
    while (file.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
    }
  }
  // The journal has some room in its files: records are made until it has none.
  const auto is_reported = [&run] {
    (void)AwaitFuture(run.observer().SetState("SelfCheck"));
    return ReportsOfTheJournal(run) > 0;
  };
  (void)AwaitThat(is_reported, kTimeout);
  MustReportTheJournal(run);
  MustKeepWorking(run);
  MustNotRepeatTheReport(run);
  fs::remove(ballast);
  RestartController(run);
}

void FileSizeIsLimited(FaultRun& run) {
  const rlimit limit{1, RLIM_INFINITY};
  run.ControllerMayDie();
  run.Require(prlimit(run.robot.RunningController(), RLIMIT_FSIZE, &limit, nullptr) == 0,
              "prlimit(RLIMIT_FSIZE)");
  run.FaultInjected();
  (void)AwaitFuture(run.observer().SetState("SelfCheck"));
  run.Require(!run.robot.ControllerHasEnded(), "the controller ended at the file size limit");
  MustReportTheJournal(run);
  MustKeepWorking(run);
  MustNotRepeatTheReport(run);
  RestartController(run);
}

void FilesAreLimited(FaultRun& run) {
  const pid_t controller = run.robot.RunningController();
  rlimit before{};
  prlimit(controller, RLIMIT_NOFILE, nullptr, &before);
  const rlimit none{3, before.rlim_max};
  run.Require(prlimit(controller, RLIMIT_NOFILE, &none, nullptr) == 0, "prlimit(RLIMIT_NOFILE)");
  const std::string victim = run.Victim({"arm", "eyes", "hands"});
  run.FaultInjected();
  kill(run.robot.PidOf(victim), SIGKILL);
  run.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  const std::string target = run.state() == "DeActive" ? "LowPower" : "DeActive";
  run.MayBecome(target);
  const auto reply = AwaitFuture(run.observer().SetState(target));
  run.Expect(reply.ok(), "no reply without file descriptors");
  prlimit(controller, RLIMIT_NOFILE, &before, nullptr);
  if (!run.observer().Await([&](const auto& s) { return IsSettled(s, target); },
                            Milliseconds(1500))) {
    (void)run.observer().Restart(victim);  // given up meanwhile
  }
  run.RecoveredIn(target);
}

void StateFolderVanishes(FaultRun& run) {
  run.ControllerMayDie();
  run.FaultInjected();
  fs::remove_all(run.robot.StateFolder());
  MustKeepWorking(run);
  RestartController(run);
  run.Expect(fs::exists(run.robot.StateFolder() / "epoch"),
             "the next controller has not created its folder");
}

void StateFolderIsReadOnly(FaultRun& run) {
  const fs::path disk = run.robot.folder() / "disk";
  run.ControllerMayDie();
  const std::string state = run.state();
  run.robot.KillController();
  MountMemory(disk, 64);
  MakeReadOnly(disk, true);
  run.robot.ForgetLines();
  run.FaultInjected();
  run.robot.StartController();
  const bool adopted = run.robot.AwaitSettled(state);
  if (adopted) run.RecoveredNow();
  if (adopted) {
    MustReportTheJournal(run);
    MustKeepWorking(run);
    MustNotRepeatTheReport(run);
    run.robot.KillController();
  }
  umount2(disk.c_str(), MNT_DETACH);
  run.Require(adopted, "without a state folder no controller adopts the robot");
  run.robot.StartController();
  run.Require(run.robot.AwaitSettled(run.observer().Latest()->state),
              "the next controller does not adopt the robot");
}

}  // namespace musher::fault_injection::resource
