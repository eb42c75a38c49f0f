#pragma once
// Ends what a test has started, also when the test fails, hangs or is killed: each process that has
// the guard's variable in its environment, whichever process is its parent.

#include <sys/types.h>

#include <string>

namespace musher::testing {

class ProcessGuard {
 public:
  // Sets the variable: the processes that are started from now on have it, also that of a guard
  // before.
  ProcessGuard();
  // Kills them, and waits until it has.
  ~ProcessGuard();
  ProcessGuard(const ProcessGuard&) = delete;
  ProcessGuard& operator=(const ProcessGuard&) = delete;

 private:
  std::string variable_;
  pid_t killer_ = 0;  // a process that kills them when `alive_` closes
  int alive_ = -1;    // the end of a pipe; of this process only
};

}  // namespace musher::testing
