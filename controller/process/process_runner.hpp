#pragma once
// Interface for starting, watching and signalling the processes of actuators. ProcessSupervisor
// implements it; the simulation has its own.
//
// Threads: loop thread only, callbacks too.

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/lifecycle/config/process_limits.hpp"

namespace musher {

struct ProcessSpec {
  std::string name;                        // of the actuator
  std::vector<std::string> argv;           // without '/': looked up in PATH; relative: from cwd
  std::string cwd;                         // empty: that of this process
  std::map<std::string, std::string> env;  // added to the inherited one without systemd's variables
  int output = -1;        // for stdout and stderr; the caller keeps it; -1: /dev/null
  std::string mark = {};  // by which a later controller finds it (child_processes.hpp); empty: none
  ProcessLimits limits = {};  // a child keeps `nice` and `realtime_priority`
};

// How a process exited.
struct ProcessExit {
  enum class Kind {
    kExited,        // number = its exit code
    kKilled,        // number = the signal
    kUnknown,       // only its exit is known; `last_output` may give the reason
    kNotRun,        // its program could not be executed; `last_output` gives the reason
    kHostWentDown,  // another host, which it ran on, was shut down or booted again
  };

  Kind kind = Kind::kUnknown;
  int number = 0;
  std::string last_output = {};  // last output of a process that exited with an error; may be empty
  // Its host had no more memory for it: what is used up, and what to do. Else empty.
  std::string out_of_memory = {};

  // Whether the process exited by itself with code 0.
  bool clean() const { return kind == Kind::kExited && number == 0; }

  // The exit code; 0 also if it was killed or the code is unknown.
  int code() const { return kind == Kind::kExited ? number : 0; }

  // "exit code 3: no such port", "killed by SIGKILL", "out of memory: …", "exit code unknown: …",
  // "its host went down".
  std::string Text() const;

  friend bool operator==(const ProcessExit&, const ProcessExit&) = default;
};

// Where a process writes its output.
struct ProcessLog {
  std::shared_ptr<const UniqueFd> file;  // null: it is no file
  std::int64_t begin = 0;                // its size at the start of the process, in bytes
};

class ProcessRunner {
 public:
  using OnExit = std::function<void(const ProcessExit&)>;

  // Leaves the processes running and unwatched.
  virtual ~ProcessRunner() = default;

  // Starts a process as the leader of its own group and watches it. If the program cannot run (not
  // found, no such cwd), Start() normally returns an Error; if a slow disk delays the loading of
  // the program, `on_exit` reports it with kind kNotRun. After success `on_exit` runs exactly once,
  // never inside Start().
  virtual Result<pid_t> Start(const ProcessSpec& spec, OnExit on_exit) = 0;

  // Watches a running process: for example, a process of the previous controller. Where a process
  // hosts several actuators, it may be watched once for each. The exit code of a process that this
  // controller did not start is unknown. Fails if there is no such process. The
  // caller must have verified the host of the pid (HostId) and its actuator (ProcessProbe::Prove).
  virtual Result<> Watch(pid_t pid, OnExit on_exit) = 0;

  // Watches a process that an earlier controller has started as its child. When the process exits,
  // the rest of its group, and all that it has started, is killed, as for a child of this
  // controller. `start_time`: from StartTimeOf(); fails if another process has the pid meanwhile.
  virtual Result<> Adopt(pid_t pid, std::uint64_t /*start_time*/, OnExit on_exit) {
    return Watch(pid, std::move(on_exit));
  }

  // Sends a signal to a started or watched process: to its whole group if it leads one. Fails if
  // the process is neither or has exited, so that it never hits another process with a reused pid.
  virtual Result<> Signal(pid_t pid, int signal) = 0;

  // The log of a process that is about to start with this output.
  virtual ProcessLog LogOf(int /*output*/) { return {}; }
  // Calls `done` with the exit of a process that this runner has not started, and with the last
  // line in its log, as for a child; maybe later, and once.
  virtual void AddLastOutput(const ProcessExit& exit, const std::string& /*name*/,
                             const ProcessLog& /*log*/, const OnExit& done) {
    done(exit);
  }
};

}  // namespace musher
