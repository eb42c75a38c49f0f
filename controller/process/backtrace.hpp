#pragma once
// Backtraces of processes of this host, for the journal: where a hung process hangs. eu-stack
// (elfutils) or, if that is not installed, gdb takes them in a process of its own; the loop
// continues meanwhile.
//
// The tool stops the process while it reads the stacks, for some tens of milliseconds to seconds. A
// killed tool may leave the process stopped; it is then continued, unless it was stopped before.
//
// Both tools need permission to trace: the same user with kernel.yama.ptrace_scope = 0, or
// CAP_SYS_PTRACE. Without symbols a frame is only an address.
//
// Threads: loop thread only, callbacks too.

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "musher/controller/process/process_runner.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher {

class BacktraceTaker {
 public:
  using Done = std::function<void(Result<std::string>)>;

  // Both must outlive the taker; `processes` runs the tools.
  BacktraceTaker(transport::EventLoop& loop, ProcessRunner& processes);
  // Kills the running tools; their `done` does not run any more.
  ~BacktraceTaker();
  BacktraceTaker(const BacktraceTaker&) = delete;
  BacktraceTaker& operator=(const BacktraceTaker&) = delete;

  // Returns the stacks of all threads as the tool prints them, at most 64 KiB and a note that the
  // rest was cut. Errors: no tool, no such process, not permitted, not within `timeout`, a
  // backtrace of the process is already being taken. `done` runs exactly once, never inside Take(),
  // and may drop the taker.
  void Take(pid_t pid, Duration timeout, Done done);

 private:
  struct Job;

  Result<> Begin(const std::shared_ptr<Job>& job, Duration timeout);
  Result<> StartTool(const std::shared_ptr<Job>& job, std::uint64_t id);
  void End(std::uint64_t id, const Result<std::string>& result);

  transport::EventLoop& loop_;
  ProcessRunner& processes_;
  std::uint64_t next_id_ = 1;  // of a job
  std::map<std::uint64_t, std::shared_ptr<Job>> jobs_;
};

}  // namespace musher
