#pragma once
// Starting a program from a process with many threads (see process_supervisor.hpp for what the
// child gets). The caller watches and reaps the child.

#include <sys/types.h>

#include "musher/controller/process_runner.hpp"
#include "musher/lifecycle/result.hpp"

namespace musher {

// Returns once the program runs, or why it does not. Threads: any.
Result<pid_t> Spawn(const ProcessSpec& spec);

}  // namespace musher
