#pragma once
// What the `musher` program tells its caller, and why.

#include <cstdint>

#include "musher/lifecycle/result.hpp"

namespace musher::cli {

enum class ExitCode : int {
  kDone = 0,
  kNotDone = 1,       // refused, undone, done-degraded; or the start-up failed
  kUsage = 2,         // a wrong command line, config or environment
  kNoController = 3,  // nobody leads a machine where we asked
  kNoAnswer = 4,      // a controller is there but did not answer in time
  kUnknownEnd = 5,    // the controller ended during a switch, and no other tells what became of it
  kInterrupted = 130  // by Ctrl-C, as shells have it
};

// Why a command could not do its work.
struct Failure {
  ExitCode exit = ExitCode::kUsage;
  Error error;
  std::uint64_t switch_number = 0;  // the switch that goes on without us; 0: none
};

}  // namespace musher::cli
