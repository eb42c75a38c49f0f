#pragma once
// A program that a test runs: its output line by line, its signals, its end.

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"

namespace musher::testing {

struct Ended {
  int exit = -1;    // -1: ended by a signal, or not at all
  int signal = 0;   // that has ended it; 0: none
  std::string out;  // all of it
  std::string err;
};

class Process {
 public:
  // Runs argv[0], looked up in PATH.
  explicit Process(const std::vector<std::string>& argv);
  // Kills it if it still runs.
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const { return pid_; }
  void Signal(int signal) const;

  // The next line of its output; none when its output ends, or at the deadline.
  std::optional<std::string> NextLine(Time deadline);
  // The next one that contains `text`; "" when its output ends, or half a minute is over, before
  // there is one.
  std::string LineWith(const std::string& text);
  // Waits until it has said so on stderr, for half a minute at most; whether it has.
  bool AwaitError(const std::string& text) const;
  // The reader of its output ends: what it prints from now on breaks a pipe.
  void CloseOutput();
  // Waits until its output ends, then for its end. To be called once.
  Ended Wait();

 private:
  // Waits for more output; false: there is none.
  bool ReadMore(Time deadline);

  pid_t pid_ = 0;
  int out_ = -1;
  int err_ = -1;          // a file without a name, so that its writer never waits
  int err_changes_ = -1;  // of inotify
  std::string read_;
  std::size_t seen_ = 0;  // of `read_`, by NextLine()
};

// Runs a program to its end.
Ended RunToEnd(const std::vector<std::string>& argv);

// From now on this process is the parent of whatever its children leave behind.
void AdoptOrphans();
// The processes that this one is the parent of.
std::vector<pid_t> Children();
// Waits until that process, of any parent, has exited; for 10 s at most. A child of this process is
// reaped.
bool AwaitEnd(pid_t pid);
// Waits until all children have exited on their own; for 10 s at most.
bool AwaitNoChildren();
// Kills all children, and theirs, until none is left.
void KillChildren();

}  // namespace musher::testing
