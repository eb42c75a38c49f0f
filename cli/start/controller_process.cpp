#include "musher/cli/start/controller_process.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "musher/base/program_path.hpp"
#include "musher/cli/console/signals.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/controller/storage/private_folder.hpp"
#include "musher/cyberdog/extension.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/wire/dds_options.hpp"

namespace musher::cli {
namespace {

constexpr Duration kLastAnswers = Milliseconds(3500);  // the shell holds them for 3 s
constexpr Duration kLastWrites = Milliseconds(2000);   // for the disk, at the end

void LeaveTerminal() {
  setsid();
  const UniqueFd nothing(open("/dev/null", O_RDWR | O_CLOEXEC));
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO}) dup2(nothing.get(), fd);
}

// So that programs installed beside this one, such as musher-exec, are found.
void PutOwnFolderFirstInPath() {
  const std::string folder = OwnProgram().parent_path();
  if (!folder.empty()) PutFirstInPath(folder);
}

// Whether the name of the controller is held by a process that is not known to lead this machine.
bool OthersHoldName(const MachineConfig& config) {
  const auto domain = transport::DomainId({});
  if (!domain) return false;
  const std::string name = NameLock::NameOf(domain.value(), config.name_space, "musher/controller");
  const NameLock::Holder holder = NameLock::HolderOf(name);
  return NameLock::IsHeld(name) && !holder.trusted;
}

}  // namespace

ControllerProcess::ControllerProcess(const MachineConfig& config, std::optional<SlotRun> run,
                                     RootLock& root_lock, UniqueFd progress, pid_t launcher,
                                     Start start)
    : config_(config),
      run_(std::move(run)),
      root_lock_(root_lock),
      launcher_(launcher),
      start_(start),
      signals_(TakeEndSignals()),
      release_(TakeSignals({kReleaseControlSignal})),
      again_(run_ ? TakeSignals({kStartAgainSignal}) : UniqueFd()),
      children_(TakeSignals({SIGCHLD})),
      progress_(loop_, std::move(progress)),
      disk_(loop_, {.name = "controller.log"}),
      log_(disk_, ControllerLogFile(config), LogMayBeLink(config.log, config.state_dir)),
      service_manager_(loop_, config) {}

int ControllerProcess::Run() {
  if (launcher_ != 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != launcher_) return static_cast<int>(ExitCode::kInterrupted);  // already exited
  }
  LeaveTerminal();
  std::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit counts as a full disk
  PutOwnFolderFirstInPath();
  if (run_) PutSlotFirstInPath(*run_);
  if (const auto begun = Begin(); !begun) {
    // A version on trial boot that cannot be started is abandoned for the previous one. That
    // another controller of the machine leads says nothing of the version.
    const bool is_led = begun.error().code == kCodeTargetBusy && !OthersHoldName(config_);
    if (is_led) PostponeTrial();
    if (!is_led && Abandon(begun.error())) return static_cast<int>(ExitCode::kUsage);
    SendProgress(Progress::kNotStarted, begun.error().message, begun.error().code);
    return static_cast<int>(ExitCode::kUsage);
  }
  loop_.Run();
  // Sends the last replies, such as that to `musher down`; not if another controller has taken
  // over.
  const auto answered = [this] { return !controller_->shell().OpenForClients(); };
  loop_.RunUntil(answered, loop_.Now() + kLastAnswers);
  const bool disk_works = controller_->Flush(kLastWrites);
  loop_.RunUntil([] { return false; }, loop_.Now());  // runs the disk's callbacks
  view_.reset();
  disk_.Flush(disk_works ? kLastWrites : Milliseconds(100));
  if (start_again_) return static_cast<int>(exit_);
  if (exit_ == ExitCode::kDone) SendProgress(Progress::kStopped, config_.name + " is stopped");
  return static_cast<int>(exit_);
}

Result<> ControllerProcess::Begin() {
  const auto domain_id = transport::DomainId({});
  if (!domain_id) return domain_id.error();
  transport::DdsOptions options =
      transport::OptionsFor(config_, transport::kControllerIdentity, transport::kControllerNode);
  options.discovery = transport::DiscoveryTiming::kOnceKnown;
  auto node = transport::MakeDdsNode(loop_, options);
  if (!node) return node.error();
  node_ = std::move(node).value();
  auto controller = Controller::Make(*node_, domain_id.value(), config_, Options());
  if (!controller) return controller.error();
  controller_ = std::move(controller).value();
  controller_->AdoptOrphans();
  children_watch_ = loop_.WhenReadable(children_.get(), [this] {
    if (NextSignal(children_) != 0) controller_->ReapOrphans();
  });
  signal_watch_ = loop_.WhenReadable(signals_.get(), [this] { OnSignal(); });
  release_watch_ = loop_.WhenReadable(release_.get(), [this] {
    pid_t sender = 0;
    if (NextSignal(release_, &sender) == 0) return;
    released_ = true;
    controller_->shell().ReleaseControl("process " + std::to_string(sender) + " of this host");
  });
  if (run_) BeginRun();
  if (!start_.standby) ShowPage();
  return Ok();
}

void ControllerProcess::ShowPage() {
  if (!config_.view || view_) return;
  view_.emplace(loop_, config_, [this](const std::string& message) { OnTrouble(message); });
}

void ControllerProcess::BeginRun() {
  if (!root_lock_.held()) {  // in a takeover the previous controller has released it by now
    if (auto locked = root_lock_.Take(run_->root); !locked) OnTrouble(locked.error().message);
  }
  if (!run_->reason.empty() && !run_->takes_down) {
    controller_->shell().Remark(run_->on_trial_boot ? kCodeOk : kCodeFailed, run_->reason);
  }
  again_watch_ = loop_.WhenReadable(again_.get(), [this] {
    pid_t sender = 0;
    if (NextSignal(again_, &sender) == 0) return;
    StartAgain("restart from the slot that is due, requested by process " + std::to_string(sender));
  });
  if (run_->takes_down) return StartAgain(run_->reason);
  if (!run_->on_trial_boot) return;
  trial_boot_.emplace(
      loop_, disk_, *run_, config_, [this] { return &controller_->shell().machine(); },
      [this](const Result<>& outcome) { OnTrialBootEnd(outcome); });
  if (start_held_) trial_boot_->Hold();
  if (start_up_ && !start_up_->usable) trial_boot_->Fail({kCodeFailed, start_up_->message});
}

// This start has not begun it: the next one does.
void ControllerProcess::PostponeTrial() {
  if (!run_ || !run_->DecidesTrial()) return;
  if (auto postponed = PostponeTrialBoot(*run_); !postponed) OnTrouble(postponed.error().message);
}

// A version on trial boot that cannot begin is abandoned for the previous one, which this process
// then starts.
bool ControllerProcess::Abandon(const Error& why) {
  start_again_ = run_ && run_->DecidesTrial() && EndTrialBoot(*run_, why);
  if (start_again_) OnTrouble("version " + run_->version + " abandoned: " + why.message);
  return start_again_;
}

void ControllerProcess::OnTrialBootEnd(const Result<>& outcome) {
  const std::string what =
      "version " + run_->version + " in slot " + std::string(ota::SlotName(run_->slot));
  if (!outcome) {
    return StartAgain(what + " is rolled back: " + outcome.error().message);
  }
  controller_->shell().Remark(kCodeOk, what + " is kept: it is up and passed its self-check");
  if (start_up_) OnStartUpEnded(*start_up_);
}

// As `musher down`, but this process then executes the program again.
void ControllerProcess::StartAgain(const std::string& why) {
  const Phase phase = controller_->shell().machine().phase;
  if (start_again_ || phase == Phase::kStopping || phase == Phase::kStopped) return;
  start_again_ = true;
  service_manager_.StartsAgain();
  controller_->shell().Remark(kCodeOk, why);
  controller_->shell().TearDown(AfterTearDown::kStartsAgain);
}

ControllerOptions ControllerProcess::Options() {
  ControllerOptions options;
  options.takeover = start_.takeover;
  options.adopt = start_.adopt;
  options.restarted = start_.restarted;
  options.supervised = start_.supervised;
  options.standby = start_.standby;
  options.on_standby = [this](const std::string& why) { OnStandby(why); };
  if (start_.standby) options.before_begin = [this] { ShowPage(); };
  if (run_) {
    options.started_from = run_->root;
    options.before_begin = [this] { EndOtherSlot(*run_); };
  }
  options.extensions = {cyberdog::Extension()};
  options.hooks.on_record = [this](const action::Record& record) { OnRecord(record); };
  options.hooks.on_start_up_ended = [this](const action::StartUpEnded& e) { OnStartUpEnded(e); };
  options.hooks.on_stopped = [this] {
    // A person has requested meanwhile that it stays down: what is due waits for the next start.
    const auto& stopping = controller_->shell().machine().stopping;
    start_again_ &= !stopping || stopping->after == AfterTearDown::kStartsAgain;
    // The machine was taken down before the trial boot was decided.
    if (trial_boot_)
      trial_boot_->Fail({kCodeFailed, "the machine was taken down before it was up"});
    loop_.Stop();
  };
  options.hooks.on_fenced = [this](const std::string& message) { OnFenced(message); };
  options.on_trouble = [this](const std::string& message) {  // from any thread
    loop_.Post([this, message] { OnTrouble(message); });
  };
  return options;
}

void ControllerProcess::OnRecord(const action::Record& record) {
  Progress progress;
  progress.wall_ns = WallNow();
  progress.kind = record.kind;
  if (record.actuator) progress.actuator = config_.actuators[*record.actuator].name;
  progress.switch_number = record.switch_number.value();
  progress.code = record.code;
  progress.message = record.message;
  progress.event = NameOf(record.event);
  progress_.Send(progress);
  log_.Write(record.message, record.code);
  if (!controller_) return;
  MarkTakingDown();
  service_manager_.Update(controller_->shell().machine());
  progress_.Send(controller_->shell().Status());
}

// Once the machine is being taken down, for the slot that is due: a start that fails before that
// has ended no actuator, and the next one does the same again.
void ControllerProcess::MarkTakingDown() {
  const bool begins = run_ && run_->takes_down && start_again_ && !marked_ &&
                      controller_->shell().machine().phase == Phase::kStopping;
  if (!begins) return;
  marked_ = true;
  disk_.Do("taking down", [run = *run_] { return SaveTakingDown(run); });
}

void ControllerProcess::OnStartUpEnded(const action::StartUpEnded& ended) {
  // This controller only completes a TearDown: the launcher stays until the machine is stopped.
  const Phase phase = controller_->shell().machine().phase;
  if (phase == Phase::kStopping || phase == Phase::kStopped) return;
  const bool decided = trial_boot_ && !trial_boot_->under_way();
  // A start that an emergency stop refuses says nothing of the version, whose trial goes on.
  const EmergencyStopState& emergency = controller_->shell().machine().emergency;
  const bool held = !ended.usable && (emergency.stop || emergency.awaits_request ||
                                      emergency.Unanswered() != nullptr);
  start_held_ |= held;
  if (held && trial_boot_) trial_boot_->Hold();
  if (run_ && run_->on_trial_boot && !decided && !held) {
    start_up_ = ended;
    if (trial_boot_ && !ended.usable) trial_boot_->Fail({kCodeFailed, ended.message});
    return;
  }
  // After a failed start the launcher exits, and the machine stays up for inspection.
  if (!ended.usable) DetachLauncher();
  service_manager_.StartUpEnded(ended);
  // The launcher may exit with it, and a person's next command reads what the start has recorded.
  controller_->OnceRecorded([this, ended] {
    SendProgress(Progress::kStartUp, ended.message, ended.usable ? kCodeOk : kCodeFailed);
  });
}

// Another controller leads, and this one is fenced; or it was refused before it began.
void ControllerProcess::OnFenced(const std::string& message) {
  start_again_ = false;  // the machine is not taken down: another controller leads it
  const bool begun = controller_->shell().machine().phase == Phase::kFenced;
  exit_ = begun ? ExitCode::kNotDone : ExitCode::kUsage;
  const bool is_led = released_ || controller_->shell().rival();
  if (!begun && is_led) PostponeTrial();
  // What runs with another config stays: the previous version is due at the next start.
  const auto& refused = controller_->shell().refused();
  const bool can_begin = begun || is_led || !refused || refused->code == kCodeTargetBusy;
  if (!can_begin && Abandon(*refused)) {
    start_again_ = !taken_down_;
    if (start_again_) return loop_.Stop();
  }
  log_.Write(message, kCodePermissionDenied);
  service_manager_.Fenced(message);
  SendProgress(begun ? Progress::kFenced : Progress::kNotStarted, message, kCodePermissionDenied);
  loop_.Stop();
}

void ControllerProcess::OnTrouble(const std::string& message) {
  SendProgress(Progress::kTrouble, message, kCodeFailed);
  log_.Write(message, kCodeFailed);
}

void ControllerProcess::OnStandby(const std::string& why) {
  log_.Write("stands by: " + why, kCodeOk);
  service_manager_.StandsBy(why);
  SendProgress(Progress::kStandby, "this host stands by for " + config_.name + ": " + why);
}

void ControllerProcess::OnSignal() {
  const int signal = NextSignal(signals_);
  if (signal == SIGHUP) return ContinueWithoutTerminal();
  if (signal != 0) TakeDown();
}

// The launcher has lost its terminal. It exits once this process reports that it has detached.
void ControllerProcess::ContinueWithoutTerminal() {
  if (launcher_ != 0) {
    DetachLauncher();
    controller_->shell().Remark(
        kCodeOk, "the terminal of `musher up` is closed; this controller keeps running");
  }
  SendProgress(Progress::kAlone, config_.name + " is led without a terminal");
}

void ControllerProcess::DetachLauncher() {
  prctl(PR_SET_PDEATHSIG, 0);
  launcher_ = 0;
}

// On a signal: Ctrl-C, or a supervisor that stops the machine.
void ControllerProcess::TakeDown() {
  taken_down_ = true;
  if (controller_->stands_by()) return loop_.Stop();
  controller_->shell().TearDown(AfterTearDown::kMayStart);
}

void ControllerProcess::SendProgress(const std::string& kind, const std::string& message,
                                     std::int32_t code) {
  progress_.Send({WallNow(), kind, "", 0, code, message});
}

}  // namespace musher::cli
