#pragma once
// The processes that a controller has started for actuators, as the next controller finds them,
// independent of their protocol and of how the first controller exited:
//
//   by the stored list  pid and start time, in a file of the state folder. The kernel never gives
//                       two processes of one boot the same pair, so a reused pid is detected
//   by their mark       a variable of their environment that names the actuator. It finds the
//                       processes that were started just before a controller was killed, or while
//                       its disk stalled; a program that clears its environment has no mark
//
// Threads: any. Reads /proc, never waits for the disk.

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"

namespace musher {

struct ChildProcess {
  std::string actuator;
  pid_t pid = 0;
  std::uint64_t start_time = 0;  // the kernel's: clock ticks since the host was booted

  friend bool operator==(const ChildProcess&, const ChildProcess&) = default;
};

// The variable that a controller sets for each process that it starts, and that the process passes
// on to its children: "0000004711/7//planner", the pid of the process and the name of the actuator
// on this host.
inline constexpr const char* kChildMark = "MUSHER_STARTED_AS";
inline constexpr std::size_t kMarkDigits = 10;  // of the pid

// The same for a unit of this host, whose pid is not known before: that of the first process of its
// session, which systemd makes for it.
inline std::string UnitMarkOf(const std::string& mark) {
  return std::string(kMarkDigits, '0') + "/" + mark;
}

// The variable in the environment that the process was started with; empty: it has none, has exited
// or hides its environment.
std::string VariableOf(pid_t pid, const std::string& name);
// The start time of the process; nullopt if it has exited, even if it is not reaped yet.
std::optional<std::uint64_t> StartTimeOf(pid_t pid);
// Whether exactly this process still runs.
bool IsRunning(const ChildProcess& child);

// The text of the file, and the processes in it. Returns none that were stored on another host, in
// another pid namespace or before this boot, and skips damaged lines.
std::string ToText(const std::vector<ChildProcess>& children, const std::string& host);
std::vector<ChildProcess> ChildrenFrom(const std::string& text, const std::string& host);
// The processes in the network namespace of the controller that has written the text. None if this
// is our own namespace: a controller here reaches them.
std::vector<ChildProcess> ChildrenInOtherNetwork(const std::string& text, const std::string& host);
// "legs (pid 4711), arm (pid 4712)".
std::string NamesOf(const std::vector<ChildProcess>& children);

// A process of our own user, pids and network that has a mark.
struct MarkedProcess {
  std::string mark;
  pid_t started = 0;  // the process that the controller has started: this one, or an ancestor
  pid_t pid = 0;
  std::uint64_t start_time = 0;
};
// Searches through all processes once.
std::vector<MarkedProcess> FindMarked();

// Those with a mark that were started with a variable whose value begins so, without this process
// and its ancestors. A process that only has the variable is a person's: a shell has exported it.
std::vector<MarkedProcess> FindMarkedWith(const std::string& name, const std::string& begin);

// An actuator with the mark of its processes.
struct MarkedActuator {
  std::string name;
  std::string mark;
  bool runs = false;  // a process holds its name: the processes with its mark are kept
};
// The actuators' processes that an earlier controller has started: at most one for each actuator,
// the stored one if it runs, else the one with the actuator's mark. Kills what an exited process
// has left behind, so that it does not disturb the next start.
std::vector<ChildProcess> FindChildren(const std::vector<MarkedActuator>& actuators,
                                       const std::vector<ChildProcess>& stored);

// The mark of a process, without its digits; empty: it has none.
std::string ChildMarkOf(pid_t pid);
// Kills what process `started` has left behind: all with its mark, but for the ancestors of this
// process.
void KillMarked(const std::string& mark, pid_t started);

}  // namespace musher
