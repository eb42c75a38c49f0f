#pragma once
// Ends the previous controller before this one takes its machine over; the actuators keep running.
//
// Threads: any; waits for the exit of the process, for some seconds at most. CheckReached(): the
// loop's.

#include <sys/types.h>

#include <functional>
#include <string>

#include "musher/base/code.hpp"
#include "musher/base/result.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/transport/node.hpp"

namespace musher {

// Whether this process may end the controller `pid` of `config`'s machine: it has received a
// heartbeat of that process by DDS, or no thread of that process runs. Else the next controller
// would reach neither it nor its actuators, which would run on without any: kCodeTargetBusy, with
// what differs. Runs the loop until then, for some seconds at most: not for a callback.
Result<> CheckReached(transport::Node& node, const MachineConfig& config, pid_t pid);

// Sends the previous controller kReleaseControlSignal, so that it can report why it exits; kills it
// if it hangs. `is_it` is called once the pidfd is open, to check that `pid` is that controller.
Result<> EndController(pid_t pid, const std::function<Result<>()>& is_it);

// Ends the controller that holds the folder's lock. The pid in the lock file is not trusted: others
// may be able to write there. A controller in another network namespace is not ended, with
// kCodeTargetBusy: its actuators would run on, and the next controller would reach none of them.
Result<> EndOwnerOf(const std::string& state_dir);

// How a person gets rid of the controller `pid`, in the message that refuses a second one.
std::string HowToReplace(pid_t pid);
// The same of the controller that holds the folder's lock; it may not be a process of this host.
std::string HowToReplaceOwnerOf(const std::string& state_dir);

// Waits until a process that was killed has exited: until then it holds its locks, on a busy
// computer for a while. Returns true when the process has exited, or does not exist; false, at
// once, if it was not killed.
bool AwaitKilled(pid_t pid);

// Returns what `take` returns, a lock or an error. If a killed process still holds the lock, waits
// for its exit and calls `take` again. `holder`: the pid of the process that holds the lock, 0 if
// it is unknown.
template <class Take>
auto TakeFromKilled(Take take, const std::function<pid_t()>& holder) {
  auto taken = take();
  if (!taken && taken.error().code == kCodeTargetBusy && AwaitKilled(holder())) taken = take();
  return taken;
}

}  // namespace musher
