#pragma once
// The processes that a controller has started for actuators, as the controller after it knows them
// again, whatever their protocol and whatever became of the first controller:
//
//   by what is stored   pid and start time, in a file of the state folder. The kernel gives no two
//                       processes of one boot the same pair, so a reused pid is told apart
//   by their mark       a variable of their environment that names the actuator. It finds what was
//                       started in the moments before a controller was killed, or while its disk
//                       let nothing through; a program that clears its environment has none
//
// Threads: any. Looks at /proc, waits for no disk.

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/result.hpp"

namespace musher {

struct ChildProcess {
  std::string actuator;
  pid_t pid = 0;
  std::uint64_t start_time = 0;  // clock ticks since the host was booted, as the kernel has it

  friend bool operator==(const ChildProcess&, const ChildProcess&) = default;
};

// The variable that a controller sets for each process that it starts; all that this one starts
// inherits it: "0000004711/7//planner", the pid of that process and the name by which the actuator
// is known on the host.
inline constexpr const char* kChildMark = "MUSHER_STARTED_AS";
inline constexpr std::size_t kMarkDigits = 10;  // of the pid

// When the process was started; nullopt when it has ended, although it may not be reaped yet.
std::optional<std::uint64_t> StartTimeOf(pid_t pid);
// Whether that very process still runs.
bool Lives(const ChildProcess& child);

// The file's text, and what it says. What was stored on another host, in another pid namespace or
// before this boot says nothing; neither does a line that is damaged.
std::string ToText(const std::vector<ChildProcess>& children, const std::string& host);
std::vector<ChildProcess> ChildrenFrom(const std::string& text, const std::string& host);

// A process of our own user that has a mark.
struct MarkedProcess {
  std::string mark;
  pid_t started = 0;  // the process that the controller has started: this one, or one before it
  pid_t pid = 0;
  std::uint64_t start_time = 0;
};
// Looks through all processes once.
std::vector<MarkedProcess> FindMarked();

// An actuator with the mark of its processes.
struct MarkedActuator {
  std::string name;
  std::string mark;
  bool runs = false;  // a process holds its name: what bears its mark is not left over
};
// Which of the actuators run in a process that an earlier controller has started: of each at most
// one, the stored one if it lives, else the one with its mark. What a process that has ended has
// left behind is killed, so that a new start does not meet it.
std::vector<ChildProcess> FindChildren(const std::vector<MarkedActuator>& actuators,
                                       const std::vector<ChildProcess>& stored);

}  // namespace musher
