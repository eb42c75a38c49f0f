#pragma once
// A process that ends itself with exit code 0 in the middle of its TearDown, as some libraries do
// on an error, would look like one that is torn down: its motors may be on. While a guard exists
// the exit code of such an end is 1, and a line on stderr names the actuator.

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
