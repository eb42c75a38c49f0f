#pragma once
// Makes sure that no process started here outlives this process, even when it is killed with
// SIGKILL: a small process beside it registers every process group that is started, and kills
// the remaining ones as soon as this process has exited or crashed. (PR_SET_PDEATHSIG would
// reach a child, but not its children, and it fires when the thread ends that made the child.)
//
// A child calls Add() itself, before it executes its program, and holds the pipe until then: the
// reaper has every group before its program runs, also when this process is killed right after
// the fork.
//
// Threads: Start() while the process has one thread; the rest from any. Add() also in a process
// that was just forked: it is async-signal-safe.

#include <sys/types.h>

#include <utility>

#include "musher/base/result.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher::exec {

class Reaper {
 public:
  // Forks.
  static Result<Reaper> Start();
  // Lets the reaper kill what is left, and waits until it has.
  ~Reaper();
  Reaper(Reaper&& other) noexcept
      : pid_(std::exchange(other.pid_, 0)), pipe_(std::move(other.pipe_)) {}
  Reaper& operator=(Reaper&&) = delete;

  // Add: `group` runs. Remove: it has ended; called before the group's leader is reaped, so that
  // its number cannot belong to another group yet.
  void Add(pid_t group) const;
  void Remove(pid_t group) const;

 private:
  Reaper(pid_t pid, UniqueFd pipe) : pid_(pid), pipe_(std::move(pipe)) {}

  pid_t pid_;
  UniqueFd pipe_;
};

}  // namespace musher::exec
