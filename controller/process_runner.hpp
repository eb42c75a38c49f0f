#pragma once
// Starting, watching and signalling the processes of actuators, as the controller sees it. The real
// one is ProcessSupervisor; the simulation has its own.
//
// Threads: loop thread only, callbacks too.

#include <sys/types.h>

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "musher/lifecycle/result.hpp"

namespace musher {

struct ProcessSpec {
  std::string name;                        // whose process it is
  std::vector<std::string> argv;           // without '/': looked up in PATH; relative: from cwd
  std::string cwd;                         // empty = ours
  std::map<std::string, std::string> env;  // on top of ours, without what systemd gave to us
  int output = -1;        // gets stdout and stderr; stays the caller's; -1 = our own
  std::string mark = {};  // by which it is known again, see child_processes.hpp; empty: none
};

// How a process ended.
struct ProcessExit {
  enum class Kind {
    kExited,   // number = its exit code
    kKilled,   // number = the signal
    kUnknown,  // it was not our child: only that it ended is known
    kNotRun    // its program could not be run; `last_words` says why
  };

  Kind kind = Kind::kUnknown;
  int number = 0;
  std::string last_words = {};  // of one that ended by itself and was not content; may be empty

  // Whether the process ended by itself and was content.
  bool clean() const { return kind == Kind::kExited && number == 0; }

  // 0 as well where it did not end by itself, or that is not known.
  int code() const { return kind == Kind::kExited ? number : 0; }

  // "exit code 3: no such port", "killed by SIGKILL", "ended (exit code unknown)".
  std::string Text() const;

  friend bool operator==(const ProcessExit&, const ProcessExit&) = default;
};

class ProcessRunner {
 public:
  using OnExit = std::function<void(const ProcessExit&)>;

  // Leaves the processes running and unwatched.
  virtual ~ProcessRunner() = default;

  // Starts a process as the leader of its own group and watches it. What keeps the program from
  // running (not found, no such cwd) is an Error of Start() where it shows at once, as it mostly
  // does; on a disk that is slow to load the program it is the process's end, of kind kNotRun.
  // After success `on_exit` runs exactly once, never inside Start().
  virtual Result<pid_t> Start(const ProcessSpec& spec, OnExit on_exit) = 0;

  // Watches a living process, e.g. one that the controller before us has started, or one of ours
  // that hosts several actuators: each of them may watch it. Of one that we did not start only its
  // end is told, not how. Fails when there is no such process. The caller knows that the pid is one
  // of this host (HostId), and whose it is (ProcessProbe::Prove).
  virtual Result<> Watch(pid_t pid, OnExit on_exit) = 0;

  // Watches a process that an earlier controller has started as its child. At its end what is left
  // of its session is killed, as for a child of ours.
  virtual Result<> Adopt(pid_t pid, OnExit on_exit) { return Watch(pid, std::move(on_exit)); }

  // Sends a signal to a started or watched process: to its whole group if it leads one. Fails when
  // the process is neither or has ended, so that it never hits a stranger with a reused pid.
  virtual Result<> Signal(pid_t pid, int signal) = 0;
};

}  // namespace musher
