#pragma once
// Runs processes for real. The kernel tells of an exit through a pidfd on the loop, so a crash is
// known in well under a millisecond and nothing is polled.
//
// A child gets its own session and process group (Ctrl-C in our terminal is not for it, and it has
// no terminal), /dev/null as stdin, the given output as stdout and stderr, no other descriptor of
// ours, and default signal handling. It outlives us: nothing is sent to it when we go or die.
//
// The last line that a child wrote into a file before it ended by itself with another exit code
// than 0 is part of the report of its end: mostly it is the reason. The disk thread reads it; a
// disk that stalls delays the report by 100 ms at most, and the line is missing then.
//
// Start() waits 10 ms at most for the program to be loaded.
//
// A process is watched once, for however many: all are told of its end at the same time.
//
// When a child has ended, what is left of its group is killed: the next start must not meet the
// remains of the one before. The same holds for an adopted process, which an earlier controller
// has started. Of a process that is only watched nothing is killed.
//
// Needs Linux 5.3. Nobody else in the process may wait for all children or ignore SIGCHLD; if so,
// the exit is still seen, but its code is unknown.

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/disk_writer.hpp"
#include "musher/controller/process_runner.hpp"
#include "musher/controller/spawn.hpp"
#include "musher/transport/event_loop.hpp"
#include "musher/transport/unique_fd.hpp"

namespace musher {

class ProcessSupervisor : public ProcessRunner {
 public:
  // `loading`: how long Start() waits for a program to be loaded. The loop and the disk must
  // outlive the supervisor.
  ProcessSupervisor(transport::EventLoop& loop, DiskWriter& disk,
                    Duration loading = Milliseconds(10))
      : loop_(loop), disk_(disk), loading_(loading) {}

  Result<pid_t> Start(const ProcessSpec& spec, OnExit on_exit) override;
  Result<> Watch(pid_t pid, OnExit on_exit) override;
  Result<> Adopt(pid_t pid, std::uint64_t start_time, OnExit on_exit) override;
  Result<> Signal(pid_t pid, int signal) override;

  // From now on what a child leaves behind, as a daemon that it started, becomes a child of this
  // process, and is killed when that child has ended. ReapOrphans() is to be called on each SIGCHLD
  // then.
  void AdoptOrphans();
  void ReapOrphans();

 private:
  struct Process {
    std::string name;
    std::uint64_t number = 0;      // in the environment of all that it starts
    std::optional<Spawned> child;  // none: it is only watched or adopted
    bool adopted = false;
    std::string mark;                          // of an adopted one (child_processes.hpp)
    std::shared_ptr<transport::UniqueFd> log;  // of a child whose output is a file
    std::int64_t log_begin = 0;                // bytes that were in it before
    std::vector<OnExit> on_exit;  // of the one that started it, then of those that watch it
    transport::UniqueFd pidfd;
    transport::LoopHandlePtr watch;  // last: its callback ends before what it uses
  };

  // A process that has ended and whose last words are being read.
  struct Ending {
    ProcessExit exit;
    std::vector<OnExit> on_exit;
    transport::LoopHandlePtr deadline;
  };

  Result<> Add(pid_t pid, Process process);
  void Ended(pid_t pid);
  void EndOrphans();
  void AwaitLastWords(const ProcessExit& exit, Process process);
  void Report(std::uint64_t ending, const std::string& last_words);

  transport::EventLoop& loop_;
  DiskWriter& disk_;
  const Duration loading_;
  std::map<pid_t, Process> processes_;
  bool adopts_ = false;
  std::uint64_t next_number_ = 1;
  std::map<std::uint64_t, Ending> endings_;
  std::uint64_t next_ending_ = 1;
  const std::shared_ptr<bool> alive_ = std::make_shared<bool>();  // expires with the supervisor
};

}  // namespace musher
