#pragma once
// A process that ends itself with exit code 0 in the middle of its TearDown, as some libraries do
// on an error, would look like one that is torn down: its motors may be on. While a guard exists
// the exit code of such an end is 1, a line on stderr names the actuator, and what the program does
// at its exit is done (glibc). Not seen are _exit(), quick_exit() and what ends by a signal.

#include <string>

namespace musher {

class ExitGuard {
 public:
  // `actuator` must outlive it. From any thread; several may exist.
  explicit ExitGuard(const std::string& actuator);
  ~ExitGuard();
  ExitGuard(const ExitGuard&) = delete;
  ExitGuard& operator=(const ExitGuard&) = delete;

 private:
  const std::string& actuator_;
};

}  // namespace musher
