#pragma once
// Ends the controller before this one, which takes its machine over; its actuators go on.
//
// Threads: any; waits for the end of the process, for some seconds at most.

#include <sys/types.h>

#include <functional>
#include <string>

#include "musher/lifecycle/result.hpp"

namespace musher {

// Ends the controller before this one; its actuators go on. It is asked, so that it can say why it
// ends; one that hangs is killed. `is_it` is asked once the process is pinned: whether `pid` is
// that controller at all.
Result<> EndController(pid_t pid, const std::function<Result<>()>& is_it);

// The one that has the folder. The lock counts, not what is in its file: others may be able to
// write there.
Result<> EndOwnerOf(const std::string& state_dir);

}  // namespace musher
