#include "musher/cli/start/slot_run.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/program_path.hpp"
#include "musher/base/scheduling.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/controller/end_controller.hpp"
#include "musher/controller/process/child_processes.hpp"
#include "musher/ota/files.hpp"
#include "musher/ota/posix_disk.hpp"
#include "musher/ota/root.hpp"
#include "musher/ota/trial_boot.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

constexpr Duration kCheckEvery = Milliseconds(100);
constexpr Duration kTermTime = Milliseconds(3000);  // from SIGTERM to SIGKILL
constexpr Duration kRunKillTime = Milliseconds(2000);
constexpr int kInstallerPollMs = 100;
constexpr auto kInstallerTime = std::chrono::minutes(10);  // a start waits for an installation
constexpr Duration kStoppedInstallerTime = std::chrono::seconds(5);  // … one that is stopped
constexpr const char* kConfigVariable = "MUSHER_CONFIG";             // of an actuator's process

// Slots are replaced by upgrades: the controller's own files must be outside of them.
std::string OutsideOfSlot(const std::string& path, const SlotRun& run) {
  const std::string slot = run.Folder() + "/";
  return path.starts_with(slot) ? run.root + "/" + path.substr(slot.size()) : path;
}

// Sends the signal to all and waits until they exit.
void SignalAll(std::vector<UniqueFd>& processes, int signal, Duration timeout) {
  for (const auto& process : processes) SendSignal(process.get(), signal);
  const Time deadline = std::chrono::steady_clock::now() + timeout;
  while (!processes.empty()) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    pollfd ended{processes.back().get(), POLLIN, 0};
    if (left.count() <= 0 || poll(&ended, 1, static_cast<int>(left.count())) != 1) return;
    processes.pop_back();
  }
}

// The slot from which a controller has started an actuator that still runs.
std::optional<ota::Slot> RunningSlot(const ota::Root& root) {
  for (const MarkedProcess& process : FindMarked()) {
    if (process.pid != process.started) continue;  // an actuator has started it
    const std::string config = VariableOf(process.pid, kConfigVariable);
    for (const ota::Slot slot : {ota::Slot::kA, ota::Slot::kB}) {
      if (config.starts_with(root.SlotFolder(slot) + "/")) return slot;
    }
  }
  return std::nullopt;
}

// Why the start does not wait for that installer any longer.
Error InstallerStays(int installer, bool stopped, const std::string& root) {
  const std::string cure =
      stopped
          ? fmt::format("it is stopped: `kill -CONT {0}` continues it, `kill -KILL {0}` ends it",
                        installer)
          : fmt::format("it has not ended within {} min: `kill {}` ends it", kInstallerTime.count(),
                        installer);
  return {kCodeTargetBusy,
          fmt::format("not started: process {} installs a version into {}; {}; then start again",
                      installer, root, cure)};
}

// Waits for the end of an installation, which is quicker than a person who starts the robot again,
// and for one that is stopped a moment. Not for ever, and no start goes on beside it: it may yet
// write into the slot that is started. Nullopt: the machine may start, perhaps without the lock.
std::optional<Error> TakeRoot(const ota::Root& root, RootLock& lock, bool takeover,
                              Console& console) {
  const auto now = [] { return std::chrono::steady_clock::now(); };
  const auto until = now() + kInstallerTime;
  std::optional<Time> stopped_since;
  const auto holder = [&root] { return ota::HolderOf(root.RunLock()); };
  for (bool first = true;; first = false) {
    const auto taken = TakeFromKilled([&] { return lock.Take(root.path()); }, holder);
    // A file system that is read-only permits no lock, and no installation.
    if (taken || taken.error().code != kCodeTargetBusy) return std::nullopt;
    const int installer = holder();
    if (installer == 0 || installer != ota::HolderOf(root.InstallLock())) {
      if (takeover) return std::nullopt;
      return Error{kCodeTargetBusy, fmt::format("process {} already leads the machine of {}; {}",
                                                installer, root.path(), HowToReplace(installer))};
    }
    const bool stopped = RunStateOf(installer) == ProcessRunState::kStopped;
    if (!stopped) stopped_since.reset();
    if (stopped && !stopped_since) stopped_since = now();
    const bool stays = stopped && now() > *stopped_since + kStoppedInstallerTime;
    if (stays || now() > until) return InstallerStays(installer, stopped, root.path());
    if (first) {
      console.PrintError(fmt::format(
          "process {} installs a version into {}; the start waits for it", installer, root.path()));
    }
    poll(nullptr, 0, kInstallerPollMs);
  }
}

}  // namespace

std::optional<ChosenSlot> ChooseSlot(const std::string& root_path, bool takeover, bool taken_down,
                                     RootLock lock, Console& console) {
  ota::PosixDisk disk;
  const auto fail = [&](const Error& error) {
    console.Fail(error);
    return std::nullopt;
  };
  const auto root = ota::Root::Open(disk, fs::canonical(root_path));
  if (!root) return fail(root.error());
  if (!lock.held()) {
    if (const auto busy = TakeRoot(root.value(), lock, takeover, console)) return fail(*busy);
  }
  // The start that is taken over may be about to begin the trial boot, or be in it.
  const bool takes_trial = !lock.held() && ota::HolderOf(root.value().RunLock()) != 0;
  auto running = taken_down ? std::nullopt : RunningSlot(root.value());
  std::string abandoned;  // why a version was abandoned
  while (true) {
    const auto before = takes_trial ? root.value().LoadState() : std::nullopt;
    const auto boot = root.value().Boot(running, takes_trial);
    if (!boot) return fail(boot.error());
    const ota::Boot& b = boot.value();
    ChosenSlot chosen{
        {root.value().path(), b.start, b.on_trial_boot, before && before->started, b.version.text,
         root.value().config().trial, abandoned.empty() ? b.reason : abandoned, b.takes_down},
        {},
        {}};
    auto config = LoadConfig(root.value().ConfigFile(b.start), console);
    if (config) {
      chosen.config = std::move(*config);
      chosen.config.state_dir = OutsideOfSlot(chosen.config.state_dir, chosen.run);
      chosen.config.log = OutsideOfSlot(chosen.config.log, chosen.run);
      chosen.lock = std::move(lock);
      return chosen;
    }
    if (b.takes_down) {  // it can't be led any more
      running.reset();
      continue;
    }
    if (!chosen.run.DecidesTrial()) return std::nullopt;
    const auto ended = EndTrialBoot(chosen.run, Error{kCodeFailed, "its state config is invalid"});
    if (!ended) return fail(ended.error());
    abandoned = "version " + b.version.text + " abandoned: its state config is invalid";
  }
}

Result<> EndTrialBoot(const SlotRun& run, const Result<>& outcome) {
  ota::PosixDisk disk;
  const auto root = ota::Root::Open(disk, run.root);
  return root ? root.value().EndTrialBoot(run.version, outcome) : Result<>(root.error());
}

Result<> PostponeTrialBoot(const SlotRun& run) {
  ota::PosixDisk disk;
  const auto root = ota::Root::Open(disk, run.root);
  return root ? root.value().PostponeTrialBoot() : Result<>(root.error());
}

Result<> SaveTakingDown(const SlotRun& run) {
  ota::PosixDisk disk;
  const auto root = ota::Root::Open(disk, run.root);
  if (!root) return root.error();
  return root.value().Change([](const ota::SlotState& state) -> Result<ota::SlotState> {
    ota::SlotState next = state;
    next.taking_down = true;
    return next;
  });
}

void PutSlotFirstInPath(const SlotRun& run) {
  PutFirstInPath(run.Folder() + "/" + ota::kProgramFolder);
}

void EndOtherSlot(const SlotRun& run) {
  SlotRun other = run;
  other.slot = ota::Other(run.slot);
  std::vector<UniqueFd> processes;
  // Of a container, or of another robot on this host, the same path is another folder.
  for (const MarkedProcess& one : FindMarkedWith(kConfigVariable, other.Folder() + "/")) {
    auto process = OpenPidfd(one.pid);
    if (!process || StartTimeOf(one.pid) != one.start_time) continue;  // a later one with its pid
    processes.push_back(std::move(process).value());
  }
  SignalAll(processes, SIGTERM, kTermTime);
  SignalAll(processes, SIGKILL, kRunKillTime);
}

Result<> RootLock::Take(const std::string& root_path) {
  disk_ = std::make_unique<ota::PosixDisk>();
  const auto root = ota::Root::Open(*disk_, root_path);
  if (!root) return root.error();
  file_ = root.value().RunLock();
  auto lock = disk_->Take(file_, /*wait=*/false);
  if (!lock) return lock.error();
  lock_ = std::move(lock).value();
  return Ok();
}

Result<> RootLock::Resume(const std::string& root_path, int fd) {
  disk_ = std::make_unique<ota::PosixDisk>();
  const auto root = ota::Root::Open(*disk_, root_path);
  if (!root) return root.error();
  file_ = root.value().RunLock();
  auto lock = ota::ResumeLock(file_, fd);
  if (!lock) return lock.error();
  lock_ = std::move(lock).value();
  return Ok();
}

int RootLock::KeepForExec() const {
  return held() ? lock_->KeepForExec() : -1;
}

void RootLock::NameThisProcess() const {
  if (held()) ota::WriteHolder(file_);
}

TrialBoot::TrialBoot(transport::EventLoop& loop, transport::DiskWriter& disk, const SlotRun& run,
                     const MachineConfig& config, std::function<const Machine*()> machine,
                     OnEnd on_end)
    : loop_(loop),
      disk_(disk),
      run_(run),
      config_(config),
      machine_(std::move(machine)),
      on_end_(std::move(on_end)),
      evaluation_(loop.Every(kCheckEvery, [this] { Evaluate(); })) {
  ExpectEnd();
}

// The time counts from the release of the last emergency stop: a person needs some of it.
void TrialBoot::ExpectEnd() {
  deadline_ = loop_.At(loop_.Now() + run_.trial, [this] {
    const Machine* machine = machine_();
    if (machine != nullptr && machine->emergency.stop) return ExpectEnd();
    Fail({kCodeTimeout, fmt::format("it was not up within {:g} s", ToSeconds(run_.trial))});
  });
}

void TrialBoot::Evaluate() {
  const Machine* machine = machine_();
  if (machine == nullptr || ending_) return;
  stop_.Note(*machine);
  if (machine->emergency.stop) ExpectEnd();
  if (const auto verdict = ota::EvaluateTrialBoot(config_, *machine, stop_)) End(*verdict);
}

void TrialBoot::Fail(const Error& why) {
  if (!ending_) End(why);
}

// If "kept" cannot be saved, the version is rolled back: the next start would do so anyway.
void TrialBoot::End(const Result<>& outcome) {
  ending_ = true;
  const auto saved = std::make_shared<Result<>>();
  disk_.Do(
      "trial",
      [run = run_, outcome, saved] {
        *saved = EndTrialBoot(run, outcome);
        return Ok();  // no retry
      },
      [this, outcome, saved](const Result<>&) {
        under_way_ = false;
        if (!outcome || *saved) return on_end_(outcome);
        const Error& why = saved->error();
        on_end_(Error{why.code, "its outcome cannot be saved: " + why.message});
      });
}

}  // namespace musher::cli
