#include "musher/base/program.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/program_path.hpp"

namespace musher {
namespace {

// A pipe that exec closes: end of file means that the program runs. Else the child writes what it
// could not do.
constexpr int kReportFd = 3;  // in the child, beside 0, 1 and 2

struct ChildFailure {
  enum Step : int { kRedirect, kChangeDirectory, kSetUp, kExecute };
  Step step;
  int error_number;
  const char* what;  // of kSetUp; the parent has it at the same address
};

// Everything the child needs, prepared before the fork.
struct ExecPlan {
  std::vector<std::string> programs;  // to be tried in this order
  std::vector<std::string> environment;
  std::vector<char*> argv;
  std::vector<char*> envp;
  UniqueFd null;
  int input = -1;
  int output = -1;
  int errors = -1;
  rlim_t max_fds = 0;
};

std::vector<char*> Pointers(const std::vector<std::string>& strings) {
  std::vector<char*> pointers;
  pointers.reserve(strings.size() + 1);
  for (const std::string& text : strings) pointers.push_back(const_cast<char*>(text.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> EnvironmentFor(const ProgramSpec& spec) {
  std::vector<std::string> environment;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    const std::string name(text.substr(0, text.find('=')));
    if (!spec.env.contains(name) && !spec.without.contains(name)) environment.emplace_back(text);
  }
  for (const auto& [name, value] : spec.env) {
    environment.emplace_back(name).append("=").append(value);
  }
  return environment;
}

// The files that the program may be, in the order of PATH.
std::vector<std::string> Candidates(const ProgramSpec& spec) {
  const std::string& program = spec.argv.front();
  if (program.find('/') != std::string::npos) return {program};
  const auto own = spec.env.find("PATH");
  return CandidatesInPath(program, own != spec.env.end() ? own->second : SearchPath());
}

Result<ExecPlan> Prepare(const ProgramSpec& spec) {
  if (spec.argv.empty() || spec.argv.front().empty()) {
    return Error{kCodeParametersInvalid, "no command"};
  }
  ExecPlan plan;
  plan.programs = Candidates(spec);
  plan.environment = EnvironmentFor(spec);
  plan.argv = Pointers(spec.argv);
  plan.envp = Pointers(plan.environment);
  plan.null = UniqueFd(open("/dev/null", O_RDONLY | O_CLOEXEC));
  if (!plan.null.valid()) return SystemError("can't open /dev/null");
  plan.input = spec.input >= 0 ? spec.input : plan.null.get();
  plan.output = spec.output;
  plan.errors = spec.errors >= 0 ? spec.errors : spec.output;
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  plan.max_fds = std::min<rlim_t>(limit.rlim_cur, 65536);
  return plan;
}

// From here to RunChild(): in the child.

[[noreturn]] void GiveUp(int report_fd, ChildFailure::Step step, const char* what = nullptr) {
  const ChildFailure failure{step, errno, what};
  // If this fails, there is no way to report it; the parent then sees the exit code.
  [[maybe_unused]] const ssize_t written = write(report_fd, &failure, sizeof(failure));
  _exit(127);
}

// SIGPIPE is ignored first: one that is pending is discarded by that.
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

// Closes everything above the report pipe. DDS opens sockets without close-on-exec.
void CloseOthers(rlim_t max_fds) {
  if (syscall(SYS_close_range, kReportFd + 1, ~0U, 0) == 0) return;
  for (rlim_t fd = kReportFd + 1; fd < max_fds; ++fd) close(static_cast<int>(fd));  // before 5.9
}

void Redirect(const ExecPlan& plan, int report_fd) {
  // Moved out of the way first, so that no dup2 below overwrites what is still needed.
  const auto aside = [](int fd) { return fd >= 0 ? fcntl(fd, F_DUPFD_CLOEXEC, 16) : -1; };
  const int report = aside(report_fd);
  const int input = aside(plan.input);
  const int output = aside(plan.output);
  const int errors = aside(plan.errors);
  if (report < 0 || input < 0) GiveUp(report_fd, ChildFailure::kRedirect);
  const bool redirected = dup2(input, 0) == 0 && (plan.output < 0 || dup2(output, 1) == 1) &&
                          (plan.errors < 0 || dup2(errors, 2) == 2);
  if (!redirected) GiveUp(report, ChildFailure::kRedirect);
  if (dup3(report, kReportFd, O_CLOEXEC) < 0) GiveUp(report, ChildFailure::kRedirect);
  CloseOthers(plan.max_fds);
}

[[noreturn]] void RunChild(const ProgramSpec& spec, const ExecPlan& plan, int report_fd) {
  if (spec.after_fork) spec.after_fork(plan.envp.data());
  Redirect(plan, report_fd);
  if (!spec.cwd.empty() && chdir(spec.cwd.c_str()) != 0) {
    GiveUp(kReportFd, ChildFailure::kChangeDirectory);
  }
  ResetSignals();
  if (const char* failed = spec.set_up ? spec.set_up() : nullptr) {
    GiveUp(kReportFd, ChildFailure::kSetUp, failed);
  }
  if (spec.before_exec && !spec.before_exec()) _exit(127);
  int reason = ENOENT;
  for (const std::string& program : plan.programs) {
    execve(program.c_str(), plan.argv.data(), plan.envp.data());
    if (errno != ENOENT && errno != ENOTDIR) reason = errno;  // e.g. found, but not executable
  }
  errno = reason;
  GiveUp(kReportFd, ChildFailure::kExecute);
}

int PollTime(std::optional<Duration> timeout) {
  if (!timeout) return -1;
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(*timeout).count();
  return static_cast<int>(std::clamp<std::int64_t>(left, 0, INT_MAX));
}

// Whether `fd` is readable within `timeout`.
bool Await(int fd, std::optional<Duration> timeout) {
  const Time begun = std::chrono::steady_clock::now();
  pollfd readable{fd, POLLIN, 0};
  while (true) {
    std::optional<Duration> left = timeout;
    if (left) *left -= std::chrono::steady_clock::now() - begun;
    const int ready = poll(&readable, 1, PollTime(left));
    if (ready >= 0 || errno != EINTR) return ready == 1;
  }
}

Result<UniqueFd> MemoryFile(const std::string& content) {
  UniqueFd file(memfd_create("program", MFD_CLOEXEC));
  if (!file.valid()) return SystemError("can't make a file in memory");
  if (!WriteAll(file.get(), content)) return SystemError("can't write a file in memory");
  lseek(file.get(), 0, SEEK_SET);
  return file;
}

std::string ContentOf(const UniqueFd& file) {
  std::string content;
  char part[4096];
  lseek(file.get(), 0, SEEK_SET);
  for (ssize_t size = 0; (size = read(file.get(), part, sizeof(part))) > 0;) {
    content.append(part, static_cast<std::size_t>(size));
  }
  return content;
}

}  // namespace

ForkedProgram::ForkedProgram(const ProgramSpec& spec, pid_t pid, UniqueFd report)
    : pid_(pid), program_(spec.argv.front()), cwd_(spec.cwd), report_(std::move(report)) {}

std::optional<ProgramFailure> ForkedProgram::Failure(std::optional<Duration> timeout) const {
  if (!Await(report_.get(), timeout)) return std::nullopt;
  ChildFailure failure{};
  if (read(report_.get(), &failure, sizeof(failure)) != sizeof(failure)) return std::nullopt;
  switch (failure.step) {
    case ChildFailure::kRedirect:
      return ProgramFailure{SystemError("can't set up its files", failure.error_number)};
    case ChildFailure::kChangeDirectory:
      return ProgramFailure{
          SystemError("can't run " + program_ + " in " + cwd_, failure.error_number)};
    case ChildFailure::kSetUp:
      return ProgramFailure{
          SystemError("can't run " + program_ + ": can't " + failure.what, failure.error_number)};
    case ChildFailure::kExecute:
      break;
  }
  return ProgramFailure{SystemError("can't run " + program_, failure.error_number),
                        failure.error_number == ENOENT};
}

Result<ForkedProgram> ForkProgram(const ProgramSpec& spec) {
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
  if (pid == 0) RunChild(spec, plan.value(), report_writer.get());
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (pid < 0) return SystemError("can't fork", fork_error);
  return ForkedProgram(spec, pid, std::move(report));
}

Result<ProgramEnd> RunProgram(const ProgramSpec& spec, const std::string& input,
                              std::optional<Duration> timeout) {
  auto given = MemoryFile(input);
  if (!given) return given.error();
  auto output = MemoryFile("");
  if (!output) return output.error();
  auto errors = MemoryFile("");
  if (!errors) return errors.error();
  ProgramSpec redirected = spec;
  redirected.input = given.value().get();
  redirected.output = output.value().get();
  redirected.errors = errors.value().get();
  auto program = ForkProgram(redirected);
  if (!program) return program.error();
  const pid_t pid = program.value().pid();
  const auto exited = OpenPidfd(pid);
  ProgramEnd end;
  end.timed_out = exited && !Await(exited.value().get(), timeout);
  if (!exited || end.timed_out) kill(pid, SIGKILL);
  end.status = ReapChild(pid).value_or(ExitStatus::Unknown());
  if (!exited) return exited.error();
  end.failure = program.value().Failure(Duration::zero());
  end.output = ContentOf(output.value());
  end.errors = ContentOf(errors.value());
  return end;
}

}  // namespace musher
