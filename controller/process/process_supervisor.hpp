#pragma once
// Runs real processes. The kernel reports an exit through a pidfd on the loop, so a crash is
// detected in well under a millisecond and nothing is polled.
//
// A child gets its own session and process group (Ctrl-C in our terminal is not for it, and it has
// no terminal), /dev/null as stdin, the given output as stdout and stderr (/dev/null without one),
// no other descriptor of ours, and default signal handling. Of its limits it keeps `nice` and
// `realtime_priority`; one that may not be set is an Error. It outlives this process, which sends
// it no signal when it exits or crashes.
//
// When a child exits by itself with another exit code than 0, the report of its exit has the last
// line that it wrote into its log file: mostly the reason. The disk thread reads it; a disk that
// stalls delays the report by 100 ms at most, and the line is missing then.
//
// Start() waits 10 ms at most for the program to be loaded; for many programs that are started at
// once 10 ms in all. A program that cannot be loaded later is reported by its exit.
//
// Several callers can watch a process: its exit is reported to all of them at the same time.
//
// When a child has exited, the rest of its process group is killed: no remains may run beside the
// next start. The same holds for an adopted process, which an earlier controller has started; with
// it all processes with its mark are killed (child_processes.hpp). For a process that is only
// watched nothing is killed.
//
// Needs Linux 5.3. No other code in the process may wait for all children or ignore SIGCHLD; if it
// does, the exit is still detected, but its code is unknown.

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/controller/process/process_runner.hpp"
#include "musher/controller/process/spawn.hpp"
#include "musher/transport/disk_writer.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher {

class ProcessSupervisor : public ProcessRunner {
 public:
  // `loading`: how long Start() waits for a program to be loaded. The loop and the disk must
  // outlive the supervisor.
  ProcessSupervisor(transport::EventLoop& loop, transport::DiskWriter& disk,
                    Duration loading = Milliseconds(10))
      : loop_(loop), disk_(disk), loading_(loading) {}

  Result<pid_t> Start(const ProcessSpec& spec, OnExit on_exit) override;
  Result<> Watch(pid_t pid, OnExit on_exit) override;
  Result<> Adopt(pid_t pid, std::uint64_t start_time, OnExit on_exit) override;
  Result<> Signal(pid_t pid, int signal) override;
  ProcessLog LogOf(int output) override;
  void AddLastOutput(const ProcessExit& exit, const std::string& name, const ProcessLog& log,
                     const OnExit& done) override;

  // Makes this process the parent of the orphans of a child, such as a daemon that it started. They
  // are killed when that child has exited. From then on ReapOrphans() is to be called
  // on each SIGCHLD.
  void AdoptOrphans();
  void ReapOrphans();

 private:
  struct Process {
    std::string name;
    std::uint64_t number = 0;            // in the environment of all its descendants
    std::optional<ForkedProgram> child;  // none: it is only watched or adopted
    bool adopted = false;
    std::string mark;             // of an adopted one (child_processes.hpp)
    ProcessLog log;               // of a child
    std::vector<OnExit> on_exit;  // of its starter, then of its watchers
    UniqueFd pidfd;
    transport::LoopHandlePtr watch;  // last: its callback ends before what it uses
  };

  // A process that has exited; the last line of its output is being read.
  struct ExitedProcess {
    ProcessExit exit;
    std::vector<OnExit> on_exit;
    transport::LoopHandlePtr deadline;
  };

  // The reason why the program of `child` cannot run, if that is known in time.
  std::optional<ProgramFailure> AwaitProgram(const ForkedProgram& child);
  Result<> Add(pid_t pid, Process process);
  void Ended(pid_t pid);
  void EndOrphans();
  void AwaitLastOutput(const ProcessExit& exit, const std::string& name, const ProcessLog& log,
                       std::vector<OnExit> on_exit);
  void Report(std::uint64_t ending, const std::string& last_output);

  transport::EventLoop& loop_;
  transport::DiskWriter& disk_;
  const Duration loading_;
  Time last_start_{};
  Duration loading_left_{};  // of the current burst of starts
  std::map<pid_t, Process> processes_;
  bool adopts_ = false;
  std::uint64_t next_number_ = 1;
  std::map<std::uint64_t, ExitedProcess> endings_;
  std::uint64_t next_ending_ = 1;
  const std::shared_ptr<bool> alive_ = std::make_shared<bool>();  // expires with the supervisor
};

}  // namespace musher
