#include "musher/controller/process/backtrace.hpp"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>
#include <vector>

#include "musher/base/host.hpp"
#include "musher/base/scheduling.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher {
namespace {

constexpr std::size_t kMostText = 64 * 1024;  // bytes
constexpr int kMostReads = 32;                // of 4 KiB at a time; a full pipe has 16

// The best tool first. gdb gets a limit of frames, so that an endless recursion of one thread
// leaves room for the others; eu-stack has a limit of its own.
std::vector<std::vector<std::string>> Tools(pid_t pid) {
  const std::string number = std::to_string(pid);
  return {{"eu-stack", "-p", number},
          {"gdb", "-p", number, "-batch", "-nx", "-ex", "thread apply all backtrace 100"}};
}

// The process to trace.
struct Target {
  UniqueFd pidfd;  // names it even when its pid is reused
  bool was_stopped = false;

  void Continue() const {
    if (!was_stopped) SendSignal(pidfd.get(), SIGCONT);
  }
};

Result<Target> FindTarget(pid_t pid) {
  if (pid == getpid()) return Error{kCodeParametersInvalid, "a process can't trace itself"};
  const auto state = RunStateOf(pid);
  if (state == ProcessRunState::kExited) {
    return Error{kCodeFailed, "there is no process " + std::to_string(pid)};
  }
  auto pidfd = OpenPidfd(pid);
  if (!pidfd) return pidfd.error();
  return Target{std::move(pidfd).value(), state == ProcessRunState::kStopped};
}

std::string LastLine(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.substr(text.rfind('\n') + 1);  // npos + 1 is 0
}

}  // namespace

struct BacktraceTaker::Job {
  pid_t pid = 0;                               // of the traced process
  std::size_t tried = 0;                       // number of tools tried
  std::string why = "no tool for backtraces";  // and why each could not be executed
  std::string tool;
  pid_t tool_pid = 0;  // 0: none runs
  Done done;
  UniqueFd output;
  std::string text;
  bool cut = false;
  transport::LoopHandlePtr timer;
  transport::LoopHandlePtr watch;  // last: its callback ends before what it uses

  // Reads what the tool has written so far, at most kMostReads parts. Reads and drops excess
  // output, too, so that the tool can exit.
  void Collect() {
    std::array<char, 4096> part{};
    ssize_t size = 0;
    for (int i = 0; i < kMostReads; ++i) {
      size = read(output.get(), part.data(), part.size());
      if (size <= 0) break;
      const std::size_t taken = std::min<std::size_t>(size, kMostText - text.size());
      text.append(part.data(), taken);
      cut = cut || taken < static_cast<std::size_t>(size);
    }
    if (size == 0) watch = nullptr;  // its end is readable for ever
  }

  Result<std::string> Outcome(const ProcessExit& exit) const {
    if (text.starts_with("#0") || text.find("\n#0") != std::string::npos) {
      return cut ? text + "\n(cut after " + std::to_string(kMostText) + " bytes)\n" : text;
    }
    const std::string about = "process " + std::to_string(pid);
    if (text.find("Operation not permitted") != std::string::npos) {
      return Error{kCodePermissionDenied,
                   tool + " is not permitted to trace " + about +
                       ": it needs kernel.yama.ptrace_scope = 0 " +
                       "and the same user, or CAP_SYS_PTRACE, and no debugger attached"};
    }
    return Error{kCodeFailed, tool + " shows no stack of " + about + ": " + exit.Text() +
                                  (text.empty() ? "" : ", " + LastLine(text))};
  }
};

BacktraceTaker::BacktraceTaker(transport::EventLoop& loop, ProcessRunner& processes)
    : loop_(loop), processes_(processes) {}

BacktraceTaker::~BacktraceTaker() {
  for (const auto& [id, job] : jobs_) {
    if (job->tool_pid != 0) static_cast<void>(processes_.Signal(job->tool_pid, SIGKILL).ok());
  }
}

void BacktraceTaker::Take(pid_t pid, Duration timeout, Done done) {
  const auto job = std::make_shared<Job>();
  job->pid = pid;
  job->done = std::move(done);
  if (const auto begun = Begin(job, timeout); !begun) {
    job->timer =
        loop_.At(loop_.Now(), [this, id = next_id_, error = begun.error()] { End(id, error); });
  }
  jobs_.emplace(next_id_++, job);
}

Result<> BacktraceTaker::Begin(const std::shared_ptr<Job>& job, Duration timeout) {
  const bool under_way = std::any_of(jobs_.begin(), jobs_.end(), [&](const auto& entry) {
    return entry.second->pid == job->pid && entry.second->tool_pid != 0;
  });
  if (under_way) {
    return Error{kCodeTargetBusy,
                 "a backtrace of process " + std::to_string(job->pid) + " is already being taken"};
  }
  if (const auto started = StartTool(job, next_id_); !started) return started.error();
  job->timer = loop_.At(loop_.Now() + timeout, [this, id = next_id_, timeout] {
    const Job& late = *jobs_.at(id);
    static_cast<void>(processes_.Signal(late.tool_pid, SIGKILL).ok());
    End(id, Error{kCodeTimeout, late.tool + " did not exit within " +
                                    std::to_string(ToMilliseconds(timeout)) + " ms"});
  });
  return Ok();
}

// Starts the next tool that can be executed.
Result<> BacktraceTaker::StartTool(const std::shared_ptr<Job>& job, std::uint64_t id) {
  auto target = FindTarget(job->pid);
  if (!target) return target.error();
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return SystemError("can't make a pipe");
  job->watch = nullptr;
  job->output = UniqueFd(ends[0]);
  const UniqueFd input(ends[1]);  // the tool gets a copy
  fcntl(job->output.get(), F_SETFL, O_NONBLOCK);

  ProcessSpec spec;
  spec.name = "backtrace";
  // English messages, which Outcome() matches, and no symbol downloads.
  spec.env = {{"LC_ALL", "C"}, {"DEBUGINFOD_URLS", ""}};
  spec.output = input.get();
  const auto on_exit =
      [this, id, weak = std::weak_ptr<Job>(job),
       target = std::make_shared<Target>(std::move(target).value())](const ProcessExit& exit) {
        if (exit.kind == ProcessExit::Kind::kKilled) target->Continue();
        const auto alive = weak.lock();
        if (!alive) return;
        if (exit.kind != ProcessExit::Kind::kNotRun) {
          alive->Collect();
          return End(id, alive->Outcome(exit));
        }
        alive->why += ", " + exit.Text();
        if (const auto started = StartTool(alive, id); !started) End(id, started.error());
      };
  const auto tools = Tools(job->pid);
  while (job->tried < tools.size()) {
    spec.argv = tools[job->tried++];
    const auto started = processes_.Start(spec, on_exit);
    if (!started) {
      job->why += ", " + started.error().message;
      continue;
    }
    job->tool = spec.argv.front();
    job->tool_pid = started.value();
    job->watch = loop_.WhenReadable(job->output.get(), [job = job.get()] { job->Collect(); });
    return Ok();
  }
  return Error{kCodeUnSupport, job->why};
}

void BacktraceTaker::End(std::uint64_t id, const Result<std::string>& result) {
  const Done done = std::move(jobs_.extract(id).mapped()->done);
  done(result);
}

}  // namespace musher
