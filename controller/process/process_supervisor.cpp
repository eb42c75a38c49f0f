#include "musher/controller/process/process_supervisor.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>

#include "musher/base/exit_status.hpp"
#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/log.hpp"
#include "musher/controller/process/child_processes.hpp"

namespace musher {
namespace {

// Reaps a child that has exited. Until then the kernel does not reuse its pid, so the pid
// identifies it as surely as the pidfd.
ProcessExit Reap(pid_t pid) {
  const auto status = ReapChild(pid);
  if (!status) return {};
  return {status->killed ? ProcessExit::Kind::kKilled : ProcessExit::Kind::kExited, status->number};
}

constexpr std::int64_t kMaxTailBytes = 2048;  // bytes of a log's end that are looked at
constexpr std::size_t kMaxLineBytes = 200;    // bytes that are reported
constexpr Duration kLastOutputTimeout = Milliseconds(500);
// Programs that are started within this time of each other are waited for together.
constexpr Duration kBurst = Milliseconds(100);

// -1: not a file.
std::int64_t SizeOf(int fd) {
  struct stat info {};
  return fstat(fd, &info) == 0 && S_ISREG(info.st_mode) ? info.st_size : -1;
}

// The last line of the file after `begin` that has a visible character; of a line of the log of
// process `name` what it says.
std::string LastOutput(int fd, std::int64_t begin, const std::string& name) {
  const std::int64_t size = SizeOf(fd);
  // A file shorter than before has been cut at its front meanwhile (log_files.hpp).
  const std::int64_t from = std::max(size < begin ? 0 : begin, size - kMaxTailBytes);
  std::string text(kMaxTailBytes, '\0');
  const ssize_t got = pread(fd, text.data(), text.size(), from);
  std::istringstream in(text.substr(0, static_cast<std::size_t>(std::max<ssize_t>(got, 0))));
  std::string line;
  std::string last;
  while (std::getline(in, line)) {
    for (char& c : line) {
      if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = ' ';
    }
    const std::size_t first = line.find_first_not_of(' ');
    if (first != std::string::npos)
      last = line.substr(first, line.find_last_not_of(' ') + 1 - first);
  }
  last = TextOfLogLine(last, name);
  if (last.size() <= kMaxLineBytes) return last;
  std::size_t end = kMaxLineBytes;
  while (end > 0 && (static_cast<unsigned char>(last[end]) & 0xC0U) == 0x80U) --end;  // UTF-8
  return last.substr(0, end) + "…";
}

// All descendants of a child inherit it.
constexpr const char* kMark = "MUSHER_PROCESS";

// "17.3": the third child of the controller whose pid is 17.
std::string MarkPrefix() {
  return std::to_string(getpid()) + ".";
}
std::string MarkOf(std::uint64_t number) {
  return MarkPrefix() + std::to_string(number);
}

// Kills the rest of the group of an adopted process that has exited. Another process is its parent
// and may have reaped it; but the kernel does not reuse the number of a group that has members.
void KillRest(pid_t pid, int pidfd) {
  const bool reaped = !SendSignal(pidfd, 0);
  const bool reused = reaped && (kill(pid, 0) == 0 || errno != ESRCH);
  if (!reused) kill(-pid, SIGKILL);
}

std::vector<pid_t> Children() {
  std::vector<pid_t> children;
  for (const auto& thread : EntriesOf("/proc/self/task")) {
    std::ifstream file(thread / "children");
    for (pid_t pid = 0; file >> pid;) children.push_back(pid);
  }
  return children;
}

// Whether its output says why it has exited.
bool HasLastWords(const ProcessExit& exit, const ProcessLog& log) {
  return log.file && exit.kind == ProcessExit::Kind::kExited && exit.number != 0;
}

void Call(const std::vector<ProcessRunner::OnExit>& all, const ProcessExit& exit) {
  for (const ProcessRunner::OnExit& on_exit : all) {
    if (on_exit) on_exit(exit);
  }
}

}  // namespace

std::string ProcessExit::Text() const {
  if (!out_of_memory.empty()) return "out of memory: " + out_of_memory;
  if (kind == Kind::kUnknown) {
    return last_output.empty() ? "exit code unknown" : "exit code unknown: " + last_output;
  }
  if (kind == Kind::kHostWentDown) return "its host went down";
  if (kind == Kind::kNotRun) return last_output;
  const std::string text = ExitStatus{kind == Kind::kKilled, number}.Text();
  return kind == Kind::kKilled || last_output.empty() ? text : text + ": " + last_output;
}

Result<pid_t> ProcessSupervisor::Start(const ProcessSpec& spec, OnExit on_exit) {
  Process process;
  process.name = spec.name;
  process.number = next_number_++;
  process.on_exit.push_back(std::move(on_exit));
  process.log = LogOf(spec.output);
  ProcessSpec marked = spec;
  marked.env[kMark] = MarkOf(process.number);
  auto child = Spawn(marked);
  if (!child) return child.error();
  const pid_t pid = child.value().pid();
  if (const auto failure = AwaitProgram(child.value())) {
    Reap(pid);
    return ErrorOf(*failure, child.value());
  }
  process.child = std::move(child).value();
  if (auto added = Add(pid, std::move(process)); !added) {
    kill(pid, SIGKILL);  // a process that cannot be watched is not kept
    kill(-pid, SIGKILL);
    Reap(pid);
    return added.error();
  }
  return pid;
}

std::optional<ProgramFailure> ProcessSupervisor::AwaitProgram(const ForkedProgram& child) {
  const Time begin = loop_.Now();
  if (begin - last_start_ > kBurst) loading_left_ = loading_;
  auto failure = child.Failure(loading_left_);
  last_start_ = loop_.Now();
  loading_left_ = std::max(loading_left_ - (last_start_ - begin), Duration::zero());
  return failure;
}

Result<> ProcessSupervisor::Watch(pid_t pid, OnExit on_exit) {
  const auto watched = processes_.find(pid);
  if (watched == processes_.end()) {
    Process process;
    process.on_exit.push_back(std::move(on_exit));
    return Add(pid, std::move(process));
  }
  watched->second.on_exit.push_back(std::move(on_exit));
  return Ok();
}

Result<> ProcessSupervisor::Adopt(pid_t pid, std::uint64_t start_time, OnExit on_exit) {
  const bool watched_before = processes_.contains(pid);
  if (auto watched = Watch(pid, std::move(on_exit)); !watched) return watched;
  // The pidfd is open: if this is the right process now, it is the right one for good.
  if (!watched_before && StartTimeOf(pid) != start_time) {
    processes_.erase(pid);
    return Error{kCodeStateInvalid, "process " + std::to_string(pid) + " has exited"};
  }
  Process& process = processes_.at(pid);
  process.adopted = !process.child && getsid(pid) == pid;
  if (process.adopted) process.mark = ChildMarkOf(pid);
  return Ok();
}

Result<> ProcessSupervisor::Signal(pid_t pid, int signal) {
  const auto found = processes_.find(pid);
  if (found == processes_.end()) {
    return Error{kCodeFailed, "process " + std::to_string(pid) + " is not ours or has ended"};
  }
  // The pidfd identifies the process even when the pid has been reused; a group has only its
  // number.
  const auto send = [&](int which) { return SendSignal(found->second.pidfd.get(), which); };
  const bool leads_group = send(0) && getpgid(pid) == pid && pid != getpgrp();
  if (leads_group ? kill(-pid, signal) == 0 : send(signal)) return Ok();
  return SystemError("can't send signal " + std::to_string(signal) + " to process " +
                     std::to_string(pid));
}

Result<> ProcessSupervisor::Add(pid_t pid, Process process) {
  auto pidfd = OpenPidfd(pid);
  if (!pidfd) return pidfd.error();
  process.pidfd = std::move(pidfd).value();
  process.watch = loop_.WhenReadable(process.pidfd.get(), [this, pid] { Ended(pid); });
  processes_.emplace(pid, std::move(process));
  return Ok();
}

void ProcessSupervisor::Ended(pid_t pid) {
  auto process = processes_.extract(pid);  // `on_exit` may start the next one
  Process& ended = process.mapped();
  if (!ended.child) {
    if (ended.adopted) {
      KillRest(pid, ended.pidfd.get());
      KillMarked(ended.mark, pid);
    }
    return Call(ended.on_exit, {});
  }
  kill(-pid, SIGKILL);  // before the leader is reaped, while the group's number is surely its own
  ProcessExit exit = Reap(pid);
  if (adopts_) EndOrphans();
  if (const auto failure = ended.child->Failure(Duration::zero())) {
    exit = {ProcessExit::Kind::kNotRun, 0, ErrorOf(*failure, *ended.child).message};
  }
  if (HasLastWords(exit, ended.log)) {
    return AwaitLastOutput(exit, ended.name, ended.log, std::move(ended.on_exit));
  }
  Call(ended.on_exit, exit);
}

ProcessLog ProcessSupervisor::LogOf(int output) {
  const std::int64_t begin = output >= 0 ? SizeOf(output) : -1;
  if (begin < 0) return {};
  return {std::make_shared<UniqueFd>(fcntl(output, F_DUPFD_CLOEXEC, 0)), begin};
}

void ProcessSupervisor::AddLastOutput(const ProcessExit& exit, const std::string& name,
                                      const ProcessLog& log, const OnExit& done) {
  HasLastWords(exit, log) ? AwaitLastOutput(exit, name, log, {done}) : done(exit);
}

void ProcessSupervisor::AdoptOrphans() {
  adopts_ = prctl(PR_SET_CHILD_SUBREAPER, 1) == 0;
}

void ProcessSupervisor::ReapOrphans() {
  if (!adopts_) return;
  for (const pid_t child : Children()) {
    if (!processes_.contains(child)) ReapEndedChild(child);
  }
  EndOrphans();  // the orphans of an orphan that has exited
}

void ProcessSupervisor::EndOrphans() {
  std::set<std::string> running;
  for (const auto& [pid, process] : processes_) running.insert(MarkOf(process.number));
  for (const pid_t child : Children()) {
    if (processes_.contains(child)) continue;
    const std::string mark = VariableOf(child, kMark);
    if (mark.starts_with(MarkPrefix()) && !running.contains(mark)) kill(child, SIGKILL);
  }
}

void ProcessSupervisor::AwaitLastOutput(const ProcessExit& exit, const std::string& name,
                                        const ProcessLog& log, std::vector<OnExit> on_exit) {
  const std::uint64_t id = next_ending_++;
  const auto output = std::make_shared<std::string>();
  endings_[id] = {exit, std::move(on_exit),
                  loop_.At(loop_.Now() + kLastOutputTimeout, [this, id] { Report(id, ""); })};
  // While the disk stalls only the last job of each name is kept: the queue is bounded.
  disk_.Do(
      "last output of " + name,
      [output, log, name] {
        *output = LastOutput(log.file->get(), log.begin, name);
        return Ok();
      },
      // A destroyed supervisor has no ending left; the disk outlives it.
      [this, id, output, alive = std::weak_ptr<bool>(alive_)](const Result<>&) {
        if (!alive.expired()) Report(id, *output);
      });
}

void ProcessSupervisor::Report(std::uint64_t ending, const std::string& last_output) {
  auto ended = endings_.extract(ending);
  if (ended.empty()) return;  // its deadline has passed
  ended.mapped().exit.last_output = last_output;
  Call(ended.mapped().on_exit, ended.mapped().exit);
}

}  // namespace musher
