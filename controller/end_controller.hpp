#pragma once
// Ends the previous controller before this one takes its machine over; the actuators keep running.
//
// Threads: any; waits for the exit of the process, for some seconds at most.

#include <sys/types.h>

#include <functional>
#include <string>

#include "musher/base/result.hpp"

namespace musher {

// Sends the previous controller kLetGoSignal, so that it can report why it exits; kills it if it
// hangs. `is_it` is called once the pidfd is open, to check that `pid` is that controller.
Result<> EndController(pid_t pid, const std::function<Result<>()>& is_it);

// Ends the controller that holds the folder's lock. The pid in the lock file is not trusted: others
// may be able to write there.
Result<> EndOwnerOf(const std::string& state_dir);

}  // namespace musher
