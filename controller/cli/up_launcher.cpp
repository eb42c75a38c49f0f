#include "musher/controller/cli/up_launcher.hpp"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "musher/controller/cli/render/json.hpp"
#include "musher/controller/cli/render/text.hpp"
#include "musher/controller/cli/signals.hpp"

namespace musher::cli {
namespace {

// "killed by signal 9 (Killed)" or "exit code 1"
std::string HowItEnded(pid_t pid) {
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFSIGNALED(status)) return "exit code " + std::to_string(WEXITSTATUS(status));
  return "killed by signal " + std::to_string(WTERMSIG(status)) + " (" +
         strsignal(WTERMSIG(status)) + ")";  // NOLINT(concurrency-mt-unsafe)
}

}  // namespace

UpLauncher::UpLauncher(Console& console, std::string machine, pid_t controller,
                       transport::UniqueFd progress, transport::UniqueFd signals, bool detach,
                       bool restarted)
    : console_(console),
      machine_(std::move(machine)),
      controller_(controller),
      detach_(detach),
      restarted_(restarted),
      signals_(std::move(signals)),
      abort_(TakeSignals({SIGABRT})),
      signal_watch_(loop_.WhenReadable(signals_.get(), [this] { OnSignal(); })),
      abort_watch_(loop_.WhenReadable(abort_.get(), [this] { OnAbort(); })),
      progress_(
          loop_, std::move(progress), [this](const Progress& p) { OnProgress(p); },
          [this] { OnEnd(); }) {
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
  if (progress.kind == Progress::kNotStarted) {
    failed_to_start_ = true;
    exit_ = console_.Fail({progress.code, progress.message});
    return;  // its end follows
  }
  if (progress.kind == Progress::kFenced) {
    fenced_ = true;
    if (console_.mode().json) console_.Print(ProgressJson(progress));
    return console_.Complain(progress.message + "; this controller ends, the actuators go on");
  }
  if (progress.kind == Progress::kAlone) {
    console_.Complain("the terminal is closed; " + Controller() +
                      ", goes on: `musher down` ends it");
    return Leave(ExitCode::kDone);
  }
  Show(progress);
  if (progress.kind == Progress::kStopped) stopped_ = true;
  if (progress.kind == Progress::kStartUp) OnStartUp(progress);
}

void UpLauncher::Show(const Progress& progress) {
  const bool said_already = progress.kind == Progress::kStartUp;  // as a record of the machine
  if (console_.mode().json) {
    console_.Print(ProgressJson(progress));
  } else if (progress.kind == Progress::kTrouble) {
    console_.Complain(progress.message);
  } else if (!said_already) {
    for (const Progress& line : repetitions_.Take(progress)) {
      console_.Print(ProgressText(line, console_.mode().colour));
    }
  }
  if (console_.HasReader() || said_unread_ || stop_asked_) return;
  said_unread_ = true;
  console_.Complain("the output is lost, its reader has ended; " + machine_ +
                    " goes on: Ctrl-C or `musher down` ends it");
}

std::string UpLauncher::Controller() const {
  return "the controller, process " + std::to_string(controller_);
}

void UpLauncher::OnStartUp(const Progress& progress) {
  if (progress.code == kCodeOk) {
    came_up_ = true;
    if (stop_asked_ || !detach_) return;
    if (!console_.mode().json) {
      console_.Print(machine_ + " is up; " + Controller() + ", stays: `musher down` ends it");
    }
    return Leave(ExitCode::kDone);
  }
  console_.Complain(progress.message);
  if (stop_asked_) return;
  console_.Complain(Controller() +
                    ", and the actuators stay up for inspection: `musher status` shows "
                    "them, `musher down` ends them");
  Leave(ExitCode::kNotDone);
}

void UpLauncher::OnEnd() {
  const std::string how = HowItEnded(controller_);
  if (stopped_) {
    if (!came_up_) console_.Complain(machine_ + " was stopped before it was up");
    return Leave(came_up_ || restarted_ ? ExitCode::kDone : ExitCode::kNotDone);
  }
  if (failed_to_start_) return Leave(exit_);
  if (fenced_) return Leave(ExitCode::kNotDone);
  Leave(
      console_.Fail({ExitCode::kNotDone,
                     {kCodeFailed, "the controller of " + machine_ + " has died (" + how +
                                       "); actuators go on without it, and `musher up` takes them "
                                       "over again"}}));
}

void UpLauncher::OnSignal() {
  const int signal = NextSignal(signals_);
  if (signal == 0) return;
  if (signal == SIGHUP) return OnTerminalClosed();
  if (stop_asked_) return console_.Complain(machine_ + " is being taken down already");
  stop_asked_ = true;
  console_.Complain("taking " + machine_ + " down");
  kill(controller_, SIGTERM);
}

// The controller is told first: until it has let go of this process, it ends with it.
void UpLauncher::OnTerminalClosed() {
  if (std::getenv("NOTIFY_SOCKET") != nullptr) {  // NOLINT(concurrency-mt-unsafe)
    return console_.Complain("SIGHUP: a service has no terminal to lose; " + machine_ + " goes on");
  }
  kill(controller_, SIGHUP);
}

// All that have ended but the controller, whose end is judged by its exit code.
void UpLauncher::ReapOrphans() {
  std::ifstream file("/proc/self/task/1/children");
  for (pid_t pid = 0; file >> pid;) {
    if (pid != controller_) waitpid(pid, nullptr, WNOHANG);
  }
}

void UpLauncher::OnAbort() {
  if (NextSignal(abort_) == 0) return;
  console_.Complain("SIGABRT: ending the controller, process " + std::to_string(controller_));
  kill(controller_, SIGABRT);
  kill(controller_, SIGCONT);  // a stopped process gets no other signal
}

void UpLauncher::Leave(ExitCode exit) {
  exit_ = exit;
  loop_.Stop();
}

}  // namespace musher::cli
