#pragma once
// Interface for the processes of actuators that run as units of systemd: on other hosts, and with
// `units = "always"` on this one. HostUnits implements it (host_units.hpp).
//
// Threads: loop thread only, callbacks too.

#include <sys/types.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/controller/process/process_runner.hpp"

namespace musher {

// The name of the unit of an actuator.
inline std::string UnitNameOf(const std::string& machine, const std::string& actuator) {
  return "musher-" + machine + "-" + actuator + ".service";
}

class HostProcesses {
 public:
  // No hook runs inside a call of this class.
  struct Hooks {
    // A process runs, with this pid on the host with this HostId() (empty: this host): Start() has
    // started it, or it was `found` running. Repeated for the same pid by Start().
    std::function<void(const std::string& actuator, pid_t pid, const std::string& host, bool found)>
        on_started;
    // `waits`: the host is out of reach, and the process is started once the host is reached.
    std::function<void(const std::string& actuator, const std::string& why, bool waits)>
        on_not_started;
    std::function<void(const std::string& actuator, pid_t pid, const ProcessExit& exit)> on_ended;
    // A host is out of reach, or is reached again.
    std::function<void(bool reached, const std::string& message)> on_reach;
    // Whether a start that waited for its host is still wanted.
    std::function<bool(const std::string& actuator)> still_starts;
    // Whether another process of the actuator is present: one that another party has started, or
    // that was out of reach. A start that waited for its host is dropped then. May be empty.
    std::function<bool(const std::string& actuator)> is_present = nullptr;
    // Whether a signal that waited for its host is still to be sent to this process.
    std::function<bool(const std::string& actuator, pid_t pid)> still_ends;
    // Whether the kernel has reported the exit of this process of this host, which systemd may not
    // have noticed yet; empty: it has not.
    std::function<bool(const std::string& actuator, pid_t pid)> has_exited = nullptr;
    // The file for stdout and stderr of a process of this host; null, or empty: the journal.
    std::function<std::shared_ptr<const UniqueFd>(const std::string& actuator)> output = nullptr;
  };

  // What Find() knows of the process of an actuator.
  struct Found {
    std::string actuator;
    pid_t pid = 0;          // 0: none runs
    std::string host;       // HostId(); empty: this host
    std::string unreached;  // why it is not known whether one runs; empty: it is
  };

  // Leaves the processes running.
  virtual ~HostProcesses() = default;

  // Connects to all hosts, and again whenever a connection is lost, until Close(). The processes
  // that run there already are reported.
  virtual void Open(Hooks hooks) = 0;
  // Starts the process of an actuator. If a process runs already, started by an earlier controller
  // or before its host was out of reach, that process is reported instead. Waits without a limit
  // for a host that is out of reach.
  virtual void Start(const ProcessSpec& spec) = 0;
  // Sends a signal to all processes of a unit on another host; a process of this host is signalled
  // by its pid (process_runner.hpp). If the host is out of reach, the signal waits
  // until it is reached again, and is dropped if another process runs there by then or the signal
  // is no longer wanted (still_ends).
  virtual void Signal(const std::string& actuator, pid_t pid, int signal) = 0;
  // Asks all hosts, within some seconds.
  virtual void Find(std::function<void(const std::vector<Found>&)> done) = 0;
  // Ends the connections, and the starts that are under way; nothing is reported any more.
  virtual void Close() = 0;
};

}  // namespace musher
