#pragma once
// A program that runs in a process group of its own, so that it can be stopped together with
// whatever it has started.
//
// A child has /dev/null as stdin, default signal handling and no descriptor of ours beyond its
// output. When it has ended, what is left of its group is killed.
//
// Threads: one at a time.

#include <sys/types.h>

#include <map>
#include <string>
#include <vector>

#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/time.hpp"
#include "musher/modules/exec/reaper.hpp"
#include "musher/transport/unique_fd.hpp"

namespace musher::exec {

struct ChildSpec {
  std::vector<std::string> argv;           // not empty; without '/': looked up in PATH
  std::string cwd;                         // empty: ours
  std::map<std::string, std::string> env;  // on top of ours
};

// How a child ended.
struct ExitStatus {
  bool killed = false;
  int number = 0;  // the exit code, or the signal that killed it

  bool ok() const { return !killed && number == 0; }
  std::string Text() const;  // "exit code 3", "killed by SIGKILL"

  friend bool operator==(const ExitStatus&, const ExitStatus&) = default;
};

class Child {
 public:
  // Fails when the program cannot be run. `output` gets its stdout and stderr; -1: ours.
  // The reaper must outlive the child.
  static Result<Child> Start(const ChildSpec& spec, const Reaper& reaper, int output = -1);
  // Kills one that still runs.
  ~Child();
  Child(Child&& other) noexcept;
  Child& operator=(Child&&) = delete;

  pid_t pid() const { return pid_; }
  int pidfd() const { return pidfd_.get(); }  // readable as soon as it has ended

  // Whether it has ended, at the latest at `deadline`.
  bool EndedBy(Time deadline) const;
  bool Ended() const { return EndedBy(Time::min()); }

  // Sends to the whole group.
  void Signal(int signal) const;

  // Waits for the end, kills what is left of the group, and gives the status; the same from then
  // on.
  ExitStatus Reap();

  // SIGTERM, and SIGKILL for one that has not ended after `stop_time`.
  ExitStatus Stop(Duration stop_time);

 private:
  Child(pid_t pid, transport::UniqueFd pidfd, const Reaper& reaper)
      : pid_(pid), pidfd_(std::move(pidfd)), reaper_(&reaper) {}

  pid_t pid_;
  transport::UniqueFd pidfd_;
  const Reaper* reaper_;
  bool reaped_ = false;
  ExitStatus status_;
};

}  // namespace musher::exec
