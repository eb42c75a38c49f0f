#pragma once
// The exit codes of the `musher` program, and failures with their exit code.

#include "musher/base/code.hpp"
#include "musher/base/result.hpp"
#include "musher/lifecycle/ids.hpp"

namespace musher::cli {

enum class ExitCode : int {
  kDone = 0,
  kNotDone = 1,       // refused, undone, done-degraded; or the start-up failed
  kUsage = 2,         // a wrong command line (also an unknown actuator), config or environment
  kNoController = 3,  // no controller in the namespace
  kNoAnswer = 4,      // the controller did not answer in time
  kUnknownEnd = 5,    // the controller exited during a request and no successor reports its outcome
  kInterrupted = 130  // by Ctrl-C, as in shells
};

// Of a request that is not carried out: an actuator or a state that the machine does not have is a
// wrong command line, as for the commands that find it without the controller.
inline ExitCode ExitCodeOfRefusal(std::int32_t code) {
  return code == kCodeParametersInvalid ? ExitCode::kUsage : ExitCode::kNotDone;
}

// Why a command failed.
struct Failure {
  ExitCode exit = ExitCode::kUsage;
  Error error;
  CommandNumber switch_number = 0;  // the switch that continues nevertheless; 0: none
};

}  // namespace musher::cli
