#pragma once
// A program in a process group of its own, so that it can be stopped together with all processes
// it has started.
//
// A child has /dev/null as stdin, default signal handling and no descriptor of this process beyond
// its output. When it has exited, what is left of its group is killed.
//
// Threads: one at a time.

#include <sys/types.h>

#include <map>
#include <string>
#include <vector>

#include "musher/base/program.hpp"
#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/modules/exec/reaper.hpp"

namespace musher::exec {

struct ChildSpec {
  std::vector<std::string> argv;           // not empty; without '/': looked up in PATH
  std::string cwd;                         // empty: that of this process
  std::map<std::string, std::string> env;  // added to that of this process
};

class Child {
 public:
  // Fails when the program cannot be run. `output` gets its stdout and stderr; -1: those of this
  // process. The reaper must outlive the child.
  static Result<Child> Start(const ChildSpec& spec, const Reaper& reaper, int output = -1);
  // Kills the child if it still runs.
  ~Child();
  Child(Child&& other) noexcept;
  Child& operator=(Child&&) = delete;

  pid_t pid() const { return pid_; }
  int pidfd() const { return pidfd_.get(); }  // readable as soon as it has exited

  // Whether it has exited, waiting until `deadline` at most.
  bool EndedBy(Time deadline) const;
  bool Ended() const { return EndedBy(Time::min()); }

  // Sends the signal to the whole group.
  void Signal(int signal) const;

  // Waits for the exit, kills what is left of the group, and returns the status; later calls
  // return the same.
  ExitStatus Reap();

  // Sends the group SIGTERM, and SIGKILL once the child has exited or `stop_time` is over. Fails if
  // it has not exited two seconds after that, or `stop_time` where that is longer. It still has to
  // be reaped: until then its number belongs to no other process.
  Result<> End(Duration stop_time) const;
  // The same, and reaps it however long that takes.
  ExitStatus Stop(Duration stop_time);

 private:
  Child(pid_t pid, UniqueFd pidfd, const Reaper& reaper)
      : pid_(pid), pidfd_(std::move(pidfd)), reaper_(&reaper) {}

  pid_t pid_;
  UniqueFd pidfd_;
  const Reaper* reaper_;
  bool reaped_ = false;
  ExitStatus status_;
};

}  // namespace musher::exec
