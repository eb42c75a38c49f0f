// Between fork and exec another thread may have left any lock of the process taken, so the child
// only makes async-signal-safe calls on memory that was prepared before. It reports through a pipe
// that exec closes: end of file means that the program runs.

#include "musher/controller/process/spawn.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/host.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/controller/process/child_processes.hpp"
#include "musher/transport/ros_environment.hpp"

namespace musher {
namespace {

constexpr int kReportFd = 3;  // in the child, beside 0, 1 and 2

// What the child could not do.
struct ChildFailure {
  enum Step : int { kRedirect, kChangeDirectory, kExecute };
  Step step;
  int error_number;
};

// Everything the child needs, prepared before the fork.
struct SpawnPlan {
  std::vector<std::string> programs;  // to be tried in this order
  std::vector<std::string> environment;
  std::vector<char*> argv;
  std::vector<char*> envp;
  char* mark = nullptr;  // digits of the child's pid in its environment; null: no mark
  std::string cwd;
  UniqueFd input;
  int output = -1;  // -1 = our own stdout and stderr
  rlim_t max_fds = 0;
  pid_t parent = 0;
};

std::vector<char*> Pointers(const std::vector<std::string>& strings) {
  std::vector<char*> result;
  result.reserve(strings.size() + 1);
  for (const auto& text : strings) result.push_back(const_cast<char*>(text.c_str()));
  result.push_back(nullptr);
  return result;
}

// What systemd gave to this process alone. An actuator that inherits it would notify systemd in the
// name of the whole robot; a program with systemd support does so on its own.
bool IsForUsOnly(std::string_view variable) {
  return variable == "NOTIFY_SOCKET" || variable == "WATCHDOG_USEC" || variable == "WATCHDOG_PID";
}

std::vector<std::string> MergedEnvironment(const std::map<std::string, std::string>& extra) {
  std::vector<std::string> result;
  for (char** entry = environ; *entry; ++entry) {
    const std::string_view text = *entry;
    const std::string_view name = text.substr(0, text.find('='));
    if (!IsForUsOnly(name) && !extra.contains(std::string(name))) result.emplace_back(text);
  }
  for (const auto& [name, value] : extra) result.emplace_back(name).append("=").append(value);
  return result;
}

std::vector<std::string> Candidates(const ProcessSpec& spec) {
  const std::string& program = spec.argv.front();
  if (program.find('/') != std::string::npos) return {program};
  const auto own = spec.env.find("PATH");
  const char* inherited = std::getenv("PATH");
  std::string_view path = own != spec.env.end() ? std::string_view(own->second)
                          : inherited           ? std::string_view(inherited)
                                                : "/usr/local/bin:/usr/bin:/bin";
  std::vector<std::string> result;
  while (true) {
    const auto end = path.find(':');
    const std::string_view folder = path.substr(0, end);
    result.push_back((folder.empty() ? "." : std::string(folder)) + "/" + program);
    if (end == std::string_view::npos) return result;
    path.remove_prefix(end + 1);
  }
}

Result<SpawnPlan> Prepare(const ProcessSpec& spec) {
  if (spec.argv.empty() || spec.argv.front().empty()) {
    return Error{kCodeParametersInvalid, "no command"};
  }
  SpawnPlan plan;
  plan.programs = Candidates(spec);
  plan.environment = MergedEnvironment(spec.env);
  if (!spec.mark.empty()) {
    const std::string begin = std::string(kChildMark) + "=";
    std::erase_if(plan.environment, [&](const auto& entry) { return entry.starts_with(begin); });
    plan.environment.push_back(begin + std::string(kMarkDigits, '0') + "/" + spec.mark);
    plan.mark = plan.environment.back().data() + begin.size();
  }
  plan.argv = Pointers(spec.argv);
  plan.envp = Pointers(plan.environment);
  plan.cwd = spec.cwd;
  plan.input = UniqueFd(open("/dev/null", O_RDONLY | O_CLOEXEC));
  if (!plan.input.valid()) return SystemError("can't open /dev/null");
  plan.output = spec.output;
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  plan.parent = getpid();
  plan.max_fds = std::min<rlim_t>(limit.rlim_cur, 65536);
  return plan;
}

// From here to RunChild(): in the child.

[[noreturn]] void GiveUp(int report_fd, ChildFailure::Step step) {
  const ChildFailure failure{step, errno};
  // If this fails, there is no way to report it; the parent then sees the exit code.
  [[maybe_unused]] const ssize_t written = write(report_fd, &failure, sizeof(failure));
  _exit(127);
}

void ResetSignals() {
  struct sigaction standard {};
  standard.sa_handler = SIG_DFL;
  for (int signal = 1; signal < NSIG; ++signal) sigaction(signal, &standard, nullptr);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
}

// Closes everything above the report pipe. DDS opens sockets without close-on-exec.
void CloseOthers(rlim_t max_fds) {
  if (syscall(SYS_close_range, kReportFd + 1, ~0U, 0) == 0) return;
  for (rlim_t fd = kReportFd + 1; fd < max_fds; ++fd) close(static_cast<int>(fd));  // before 5.9
}

void WriteDigits(char* digits, pid_t number) {
  for (std::size_t i = kMarkDigits; i > 0; --i, number /= 10) {
    digits[i - 1] = static_cast<char>('0' + number % 10);
  }
}

[[noreturn]] void RunChild(const SpawnPlan& plan, int report_fd) {
  setsid();
  if (plan.mark != nullptr) WriteDigits(plan.mark, getpid());
  // Moved out of the way first, so that no dup2 below overwrites what is still needed.
  const int report = fcntl(report_fd, F_DUPFD_CLOEXEC, 16);
  const int input = fcntl(plan.input.get(), F_DUPFD_CLOEXEC, 16);
  const int output = plan.output >= 0 ? fcntl(plan.output, F_DUPFD_CLOEXEC, 16) : -1;
  if (report < 0 || input < 0) GiveUp(report_fd, ChildFailure::kRedirect);
  if (dup2(input, 0) < 0) GiveUp(report, ChildFailure::kRedirect);
  if (plan.output >= 0 && (dup2(output, 1) < 0 || dup2(output, 2) < 0)) {
    GiveUp(report, ChildFailure::kRedirect);
  }
  if (dup3(report, kReportFd, O_CLOEXEC) < 0) GiveUp(report, ChildFailure::kRedirect);
  CloseOthers(plan.max_fds);
  if (!plan.cwd.empty() && chdir(plan.cwd.c_str()) != 0) {
    GiveUp(kReportFd, ChildFailure::kChangeDirectory);
  }
  ResetSignals();
  // The next controller finds this process only after execve, by the mark in its environment; if
  // this controller has exited meanwhile, the process exits.
  if (getppid() != plan.parent) _exit(127);
  int reason = ENOENT;
  for (const auto& program : plan.programs) {
    execve(program.c_str(), plan.argv.data(), plan.envp.data());
    if (errno != ENOENT && errno != ENOTDIR) reason = errno;  // e.g. found, but not executable
  }
  errno = reason;
  GiveUp(kReportFd, ChildFailure::kExecute);
}

}  // namespace

Spawned::Spawned(const ProcessSpec& spec, pid_t pid, UniqueFd report)
    : pid_(pid), program_(spec.argv.front()), cwd_(spec.cwd), report_(std::move(report)) {}

std::optional<Error> Spawned::Failure(Duration timeout) const {
  pollfd reported{report_.get(), POLLIN, 0};
  if (poll(&reported, 1, static_cast<int>(ToMilliseconds(timeout))) != 1) return std::nullopt;
  ChildFailure failure{};
  if (read(report_.get(), &failure, sizeof(failure)) != sizeof(failure)) return std::nullopt;
  switch (failure.step) {
    case ChildFailure::kRedirect:
      return SystemError("can't set up its files", failure.error_number);
    case ChildFailure::kChangeDirectory:
      return SystemError("can't enter " + cwd_, failure.error_number);
    case ChildFailure::kExecute:
      break;
  }
  Error error = SystemError("can't run " + program_, failure.error_number);
  if (failure.error_number == ENOENT) error.message += transport::MissingProgramHint(program_);
  return error;
}

Result<Spawned> Spawn(const ProcessSpec& spec) {
  const auto plan = Prepare(spec);
  if (!plan) return plan.error();
  int ends[2];
  if (pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) return SystemError("can't make a pipe");
  UniqueFd report(ends[0]);
  const UniqueFd report_writer(ends[1]);

  // A signal that comes between fork and exec must not run one of our handlers in the child.
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const pid_t pid = fork();
  const int fork_error = errno;
  if (pid == 0) RunChild(plan.value(), report_writer.get());
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (pid < 0) return SystemError("can't fork", fork_error);
  return Spawned(spec, pid, std::move(report));
}

}  // namespace musher
