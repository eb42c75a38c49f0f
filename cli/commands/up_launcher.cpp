#include "musher/cli/commands/up_launcher.hpp"

#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "musher/base/exit_status.hpp"
#include "musher/cli/console/signals.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/lifecycle/event_name.hpp"

namespace musher::cli {
namespace {

constexpr Duration kBeginsWithin = std::chrono::seconds(10);

}  // namespace

UpLauncher::UpLauncher(Console& console, const MachineConfig& config, pid_t controller,
                       UniqueFd progress, UniqueFd signals, bool detach, bool restarted)
    : console_(console),
      machine_(config.name),
      controller_(controller),
      detach_(detach),
      restarted_(restarted),
      signals_(std::move(signals)),
      abort_(TakeSignals({SIGABRT})),
      signal_watch_(loop_.WhenReadable(signals_.get(), [this] { OnSignal(); })),
      abort_watch_(loop_.WhenReadable(abort_.get(), [this] { OnAbort(); })),
      table_(loop_, console,
             [&config](const std::string& actuator, const std::string& state) {
               const auto i = config.IndexOf(actuator);
               return i && !state.empty() ? std::optional(config.TimeFor(*i, state)) : std::nullopt;
             }),
      progress_(
          loop_, std::move(progress), [this](const Progress& p) { OnProgress(p); },
          [this] { OnEnd(); }) {
  console_.TakeLost();  // Show() reports it
  begin_watch_ = loop_.At(loop_.Now() + kBeginsWithin, [this, folder = config.state_dir] {
    console_.PrintError(Controller() + " has not begun yet; perhaps the disk of " + folder +
                        " does not answer");
  });
  if (getpid() != 1) return;
  children_ = TakeSignals({SIGCHLD});
  children_watch_ = loop_.WhenReadable(children_.get(), [this] {
    if (NextSignal(children_) != 0) ReapOrphans();
  });
}

ExitCode UpLauncher::Run() {
  loop_.Run();
  return exit_;
}

void UpLauncher::OnProgress(const Progress& progress) {
  begin_watch_ = nullptr;
  if (progress.kind == Progress::kMachine) return table_.Show(progress.machine);
  if (progress.kind == Progress::kNotStarted) {
    failed_to_start_ = true;
    exit_ = console_.Fail({progress.code, progress.message});
    return;  // the controller exits next
  }
  if (progress.kind == Progress::kFenced) {
    fenced_ = true;
    if (console_.mode().json) console_.Print(ProgressJson(progress));
    return console_.PrintError(progress.message +
                               "; this controller exits, the actuators keep running");
  }
  if (progress.kind == Progress::kAlone) {
    console_.PrintError("the terminal is closed; " + Controller() +
                        " keeps running: `musher down` stops it");
    return Leave(ExitCode::kDone);
  }
  Show(progress);
  if (progress.kind == Progress::kStopped) stopped_ = true;
  if (progress.event == NameOf(EventName::kMachineStopped) && progress.code != kCodeOk) {
    incomplete_stop_ = progress.message;
  }
  if (progress.kind == Progress::kStartUp) OnStartUp(progress);
  if (progress.kind == Progress::kStandby) OnStandby();
}

void UpLauncher::OnStandby() {
  came_up_ = true;
  if (detach_ && !stop_requested_) Leave(ExitCode::kDone);
}

void UpLauncher::Show(const Progress& progress) {
  const bool printed = progress.kind == Progress::kStartUp;  // already, as a record of the machine
  if (console_.mode().json) {
    console_.Print(ProgressJson(progress));
  } else if (progress.kind == Progress::kTrouble) {
    console_.PrintError(progress.message);
  } else if (!printed) {
    for (const Progress& line : repetitions_.Take(progress)) {
      console_.Print(ProgressText(line, console_.mode().colour));
    }
  }
  if (console_.HasReader() || reported_unread_ || stop_requested_) return;
  reported_unread_ = true;
  console_.PrintError("output lost: " + console_.lost() + "; " + machine_ +
                      " keeps running: Ctrl-C or `musher down` stops it");
}

std::string UpLauncher::Controller() const {
  return "the controller (pid " + std::to_string(controller_) + ")";
}

void UpLauncher::OnStartUp(const Progress& progress) {
  if (progress.code == kCodeOk) {
    came_up_ = true;
    if (stop_requested_ || !detach_) return;
    if (!console_.mode().json) {
      console_.Print(machine_ + " is up; " + Controller() +
                     " keeps running: `musher down` stops it");
    }
    return Leave(ExitCode::kDone);
  }
  console_.PrintError(progress.message);
  if (stop_requested_) return;
  console_.PrintError(Controller() +
                      " and the actuators stay up for inspection: `musher status` shows "
                      "them, `musher down` stops them");
  Leave(ExitCode::kNotDone);
}

void UpLauncher::OnEnd() {
  const auto status = ReapChild(controller_);
  if (stopped_) {
    if (!came_up_) console_.PrintError(machine_ + " was stopped before it was up");
    if (!incomplete_stop_.empty()) console_.PrintError(incomplete_stop_);
    // A supervisor would start the machine again after a failure.
    const bool good = (came_up_ && incomplete_stop_.empty()) || restarted_;
    return Leave(good ? ExitCode::kDone : ExitCode::kNotDone);
  }
  if (failed_to_start_) return Leave(exit_);
  // A supervisor must not start again what a person has replaced.
  if (fenced_) return Leave(restarted_ ? ExitCode::kUsage : ExitCode::kNotDone);
  const std::string how = status ? status->Text() : "exit code unknown";
  Leave(console_.Fail({ExitCode::kNotDone,
                       {kCodeFailed, "the controller of " + machine_ + " has crashed (" + how +
                                         "); actuators keep running, and `musher up` takes control "
                                         "of them again"}}));
}

void UpLauncher::OnSignal() {
  const int signal = NextSignal(signals_);
  if (signal == 0) return;
  if (signal == SIGHUP) return OnTerminalClosed();
  if (stop_requested_) return console_.PrintError(machine_ + " is already being taken down");
  stop_requested_ = true;
  console_.PrintError("taking " + machine_ + " down");
  kill(controller_, SIGTERM);
}

// The controller gets the signal first: until it detaches from this process, it is killed with it.
void UpLauncher::OnTerminalClosed() {
  if (std::getenv("NOTIFY_SOCKET") != nullptr) {  // NOLINT(concurrency-mt-unsafe)
    return console_.PrintError("SIGHUP ignored: a service has no terminal; " + machine_ +
                               " keeps running");
  }
  kill(controller_, SIGHUP);
}

// Reaps all exited children except the controller, whose exit code is still needed.
void UpLauncher::ReapOrphans() {
  std::ifstream file("/proc/self/task/1/children");
  for (pid_t pid = 0; file >> pid;) {
    if (pid != controller_) ReapEndedChild(pid);
  }
}

void UpLauncher::OnAbort() {
  if (NextSignal(abort_) == 0) return;
  console_.PrintError("SIGABRT: aborting " + Controller());
  kill(controller_, SIGABRT);
  kill(controller_, SIGCONT);  // a stopped process gets no other signal
}

void UpLauncher::Leave(ExitCode exit) {
  table_.Hide();
  exit_ = exit;
  loop_.Stop();
}

}  // namespace musher::cli
