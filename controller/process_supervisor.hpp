#pragma once
// Runs processes for real. The kernel tells of an exit through a pidfd on the loop, so a crash is
// known in well under a millisecond and nothing is polled.
//
// A child gets its own session and process group (Ctrl-C in our terminal is not for it, and it has
// no terminal), /dev/null as stdin, the log file as stdout and stderr, no other descriptor of ours,
// and default signal handling. It outlives us: nothing is sent to it when we go or die.
//
// The last line that a child wrote before it ended by itself with another exit code than 0 is part
// of what is told of its end: mostly it is the reason.
//
// A process is watched once, for however many: all are told of its end at the same time.
//
// When a child has ended, what is left of its group is killed: the next start must not meet the
// remains of the one before. Of a process that is only watched nothing is killed.
//
// Needs Linux 5.3. Nobody else in the process may wait for all children or ignore SIGCHLD; if so,
// the exit is still seen, but its code is unknown.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "musher/controller/process_runner.hpp"
#include "musher/transport/event_loop.hpp"
#include "musher/transport/unique_fd.hpp"

namespace musher {

class ProcessSupervisor : public ProcessRunner {
 public:
  // The loop must outlive the supervisor.
  explicit ProcessSupervisor(transport::EventLoop& loop) : loop_(loop) {}

  Result<pid_t> Start(const ProcessSpec& spec, OnExit on_exit) override;
  Result<> Watch(pid_t pid, OnExit on_exit) override;
  Result<> Signal(pid_t pid, int signal) override;

 private:
  struct Process {
    bool is_child = false;
    std::string log_file;
    std::int64_t log_begin = 0;   // bytes that were in it before
    std::vector<OnExit> on_exit;  // of the one that started it, then of those that watch it
    transport::UniqueFd pidfd;
    transport::LoopHandlePtr watch;  // last: its callback ends before what it uses
  };

  Result<> Add(pid_t pid, Process process);
  void Ended(pid_t pid);

  transport::EventLoop& loop_;
  std::map<pid_t, Process> processes_;
};

}  // namespace musher
