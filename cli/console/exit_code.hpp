#pragma once
// The exit codes of the `musher` program, and failures with their exit code.

#include "musher/base/result.hpp"
#include "musher/lifecycle/ids.hpp"

namespace musher::cli {

enum class ExitCode : int {
  kDone = 0,
  kNotDone = 1,       // refused, undone, done-degraded; or the start-up failed
  kUsage = 2,         // a wrong command line, config or environment
  kNoController = 3,  // no controller in the namespace
  kNoAnswer = 4,      // the controller did not answer in time
  kUnknownEnd = 5,    // the controller exited during a request and no successor reports its outcome
  kInterrupted = 130  // by Ctrl-C, as in shells
};

// Why a command failed.
struct Failure {
  ExitCode exit = ExitCode::kUsage;
  Error error;
  CommandNumber switch_number = 0;  // the switch that continues nevertheless; 0: none
};

}  // namespace musher::cli
