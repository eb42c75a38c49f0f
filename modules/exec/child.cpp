#include "musher/modules/exec/child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/transport/ros_environment.hpp"

namespace musher::exec {
namespace {

std::vector<char*> Pointers(const std::vector<std::string>& strings) {
  std::vector<char*> pointers;
  pointers.reserve(strings.size() + 1);
  for (const std::string& text : strings) pointers.push_back(const_cast<char*>(text.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> Environment(const std::map<std::string, std::string>& extra) {
  std::vector<std::string> environment;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    if (!extra.contains(std::string(text.substr(0, text.find('=')))))
      environment.emplace_back(text);
  }
  for (const auto& [name, value] : extra) {
    environment.emplace_back(name).append("=").append(value);
  }
  return environment;
}

// The files that `program` may be, in the order of PATH.
std::vector<std::string> Candidates(const std::string& program,
                                    const std::map<std::string, std::string>& env) {
  if (program.find('/') != std::string::npos) return {program};
  const auto own = env.find("PATH");
  const char* inherited = std::getenv("PATH");  // NOLINT(concurrency-mt-unsafe)
  std::string_view path = own != env.end()       ? std::string_view(own->second)
                          : inherited != nullptr ? std::string_view(inherited)
                                                 : "/bin:/usr/bin";
  std::vector<std::string> candidates;
  while (true) {
    const std::size_t end = path.find(':');
    const std::string_view folder = path.substr(0, end);
    candidates.push_back((folder.empty() ? "." : std::string(folder)) + "/" + program);
    if (end == std::string_view::npos) return candidates;
    path.remove_prefix(end + 1);
  }
}

// All that the child needs, made before the fork: other threads may hold any lock then, so the
// child only makes async-signal-safe calls.
struct Plan {
  std::vector<std::string> programs;
  std::vector<std::string> arguments;
  std::vector<std::string> environment;
  std::vector<char*> argv;
  std::vector<char*> envp;
  std::string cwd;
  int output = -1;

  Plan(const ChildSpec& spec, int output_fd)
      : programs(Candidates(spec.argv.front(), spec.env)),
        arguments(spec.argv),
        environment(Environment(spec.env)),
        argv(Pointers(arguments)),
        envp(Pointers(environment)),
        cwd(spec.cwd),
        output(output_fd) {}
};

// SIGPIPE is ignored first: a SIGPIPE that is pending because the reaper has exited is discarded
// by that.
void ResetSignals() {
  struct sigaction action {};
  action.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &action, nullptr);
  action.sa_handler = SIG_DFL;
  for (int signal = 1; signal < NSIG; ++signal) sigaction(signal, &action, nullptr);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
}

// In the child. Returns the reason why the program does not run.
int Execute(const Plan& plan, int report) {
  close(0);
  const bool redirected = open("/dev/null", O_RDONLY) == 0 &&
                          (plan.output < 0 || (dup2(plan.output, 1) == 1 && dup2(1, 2) == 2));
  if (!redirected) return errno;
  if (!plan.cwd.empty() && chdir(plan.cwd.c_str()) != 0) return errno;
  // DDS opens sockets without close-on-exec. Only the pipe is needed until the program runs.
  if (report > 3) close_range(3, static_cast<unsigned>(report) - 1, 0);
  close_range(static_cast<unsigned>(report) + 1, ~0U, 0);
  ResetSignals();
  int reason = ENOENT;
  for (const std::string& program : plan.programs) {
    execve(program.c_str(), plan.argv.data(), plan.envp.data());
    if (errno != ENOENT && errno != ENOTDIR) reason = errno;  // e.g. found, but not executable
  }
  return reason;
}

// Forks. The child registers with the reaper before it executes the program: from then on it is
// killed when this process exits or crashes.
pid_t Fork(const Plan& plan, const Reaper& reaper, int report) {
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);  // no handler of this process runs in the child
  const pid_t pid = fork();
  if (pid == 0) {
    setpgid(0, 0);
    reaper.Add(getpid());
    const int reason = Execute(plan, report);
    [[maybe_unused]] const ssize_t written = write(report, &reason, sizeof(reason));
    _exit(127);
  }
  const int error = errno;
  if (pid > 0) setpgid(pid, pid);  // the child does so too; either call creates the group
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  errno = error;
  return pid;
}

// Waits until the program runs; else returns the error number.
int AwaitProgram(const UniqueFd& report) {
  int reason = 0;
  ssize_t got = 0;
  do {
    got = read(report.get(), &reason, sizeof(reason));
  } while (got < 0 && errno == EINTR);
  return got == sizeof(reason) ? reason : 0;  // the pipe closes when the program is executed
}

}  // namespace

std::string ExitStatus::Text() const {
  if (!killed) return "exit code " + std::to_string(number);
  const char* name = sigabbrev_np(number);
  return "killed by " +
         (name != nullptr ? "SIG" + std::string(name) : "signal " + std::to_string(number));
}

Result<Child> Child::Start(const ChildSpec& spec, const Reaper& reaper, int output) {
  const Plan plan(spec, output);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return SystemError("can't make a pipe");
  const UniqueFd report(ends[0]);
  UniqueFd writer(ends[1]);
  const pid_t pid = Fork(plan, reaper, writer.get());
  if (pid < 0) return SystemError("can't fork");
  writer = {};
  auto pidfd = OpenPidfd(pid);
  Child child(pid, pidfd ? std::move(pidfd).value() : UniqueFd(), reaper);
  if (!child.pidfd_.valid()) return SystemError("can't watch " + spec.argv.front());
  const int error = AwaitProgram(report);
  if (error == 0) return child;
  const std::string where = spec.cwd.empty() ? "" : " in " + spec.cwd;
  Error failure = SystemError("can't run " + spec.argv.front() + where, error);
  if (error == ENOENT) failure.message += transport::MissingProgramHint(spec.argv.front());
  return failure;
}

Child::Child(Child&& other) noexcept
    : pid_(std::exchange(other.pid_, 0)),
      pidfd_(std::move(other.pidfd_)),
      reaper_(other.reaper_),
      reaped_(other.reaped_),
      status_(other.status_) {}

Child::~Child() {
  if (pid_ == 0 || reaped_) return;
  Signal(SIGKILL);
  Reap();
}

bool Child::EndedBy(Time deadline) const {
  if (reaped_) return true;
  pollfd ended{pidfd_.get(), POLLIN, 0};
  while (true) {
    const Time now = std::chrono::steady_clock::now();
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(std::max(deadline, now) - now);
    const auto timeout = std::min<std::int64_t>(left.count(), INT_MAX);
    const int ready = poll(&ended, 1, static_cast<int>(timeout));
    if (ready >= 0 || errno != EINTR) return ready > 0;
  }
}

void Child::Signal(int signal) const {
  if (!reaped_) kill(-pid_, signal);
}

ExitStatus Child::Reap() {
  if (reaped_) return status_;
  siginfo_t info{};
  while (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOWAIT) != 0 && errno == EINTR) {
  }
  kill(-pid_, SIGKILL);  // before the leader is reaped, while the group's number cannot be reused
  reaper_->Remove(pid_);
  while (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED) != 0 && errno == EINTR) {
  }
  reaped_ = true;
  status_ = {info.si_code != CLD_EXITED, info.si_status};
  return status_;
}

ExitStatus Child::Stop(Duration stop_time) {
  Signal(SIGTERM);
  if (!EndedBy(std::chrono::steady_clock::now() + stop_time)) Signal(SIGKILL);
  return Reap();
}

}  // namespace musher::exec
