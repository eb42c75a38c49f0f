#pragma once
// How a process has ended, and how its parent finds out.
//
// Threads: any.

#include <sys/types.h>

#include <optional>
#include <string>

namespace musher {

struct ExitStatus {
  bool killed = false;
  int number = 0;  // the exit code, or the signal that killed it

  static ExitStatus FromWait(int status);            // as waitpid() gives it
  static ExitStatus Unknown() { return {true, 0}; }  // another process has reaped it: not ok()

  bool ok() const { return !killed && number == 0; }
  std::string Text() const;  // "exit code 3", "killed by SIGKILL", "exit status unknown"

  friend bool operator==(const ExitStatus&, const ExitStatus&) = default;
};

// Waits until the child has ended, and reaps it. nullopt: this process has no such child, or has
// reaped it already.
std::optional<ExitStatus> ReapChild(pid_t pid);

// Reaps the child if it has ended. Does not wait: nullopt, too, while the child runs.
std::optional<ExitStatus> ReapEndedChild(pid_t pid);

}  // namespace musher
