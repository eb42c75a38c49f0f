#pragma once
// Judges which actuators live, from what is heard of them. Pure: it is told what was heard and what
// time it is, and says whom to ask, whom to look at, and whose health has changed.
//
//   heard ──▶ quiet for half its limit: it is asked (Probe), and the kernel's view of it is taken
//     ▲       as a mark (Examine) where that is possible
//     │                 │
//     └── heard again ──┤ silent for its limit
//                       ▼
//          of this host: Examine ──▶ waited for a CPU: starved   stopped, or had its chances: hung
//          elsewhere:    others of its host are heard ──▶ crashed      nobody is ──▶ partitioned
//
// The end of a process is no matter of this: the kernel tells it at once. A program of another
// protocol that sends no heartbeats is not judged, unless it is a ROS 2 node with a checkpoint: it
// answers questions.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/health.hpp"

namespace musher {

// How often an actuator says that it lives: twice in its checkpoint, at most 500 ms apart, and 125
// ms where hosts are several, since there nothing else tells of its end. Three that are missed in a
// row are silence.
Duration HeartbeatPeriod(const MachineConfig& config, std::size_t actuator);
// How often a controller does.
Duration ControllerBeatPeriod(const MachineConfig& config);

// What an actuator says of itself.
struct Heartbeat {
  Duration period{};            // until the next one
  Health work = Health::kWell;  // of its work thread: well, starved or hung
  State during;                 // whose callback runs; empty for work of its own
  Duration silent{};            // since the work thread's last checkpoint
  Duration waited{};            // so much of it, it waited for a CPU
};

// What the kernel says of a process of this host.
struct Examination {
  enum class Process { kRunning, kStopped, kTraced, kGone };

  Process process = Process::kRunning;
  Duration waited{};  // its longest wait for a CPU since the mark, or our own
};

namespace finding {
// Ask it anything: who answers lives.
struct Probe {
  std::size_t actuator = 0;
};
// Look at its process; with `mark`, remember the look to measure from.
struct Examine {
  std::size_t actuator = 0;
  bool mark = false;
};
struct Changed {
  std::size_t actuator = 0;
  std::uint64_t incarnation = 0;
  Health health = Health::kWell;
  bool silent = false;  // it does not even answer
  std::string how;      // "for 512 ms nothing was heard of it"
};
}  // namespace finding

using Finding = std::variant<finding::Probe, finding::Examine, finding::Changed>;

class HealthMonitor {
 public:
  explicit HealthMonitor(const MachineConfig& config);

  // An actuator is to be watched from now on. `local`: the kernel can be asked about its process.
  void Watch(std::size_t actuator, std::uint64_t incarnation, const std::string& host, bool local,
             Time now);
  // Its process has ended.
  void Forget(std::size_t actuator);

  // Anything came from it: a status, an answer.
  std::vector<Finding> Heard(std::size_t actuator, std::uint64_t incarnation, Time now);
  std::vector<Finding> Heard(std::size_t actuator, std::uint64_t incarnation,
                             const Heartbeat& heartbeat, Time now);
  std::vector<Finding> Examined(std::size_t actuator, const Examination& examination, Time now);
  std::vector<Finding> TimePassed(Time now);

  std::optional<Time> NextDeadline() const;

 private:
  struct MonitoredProcess {
    std::uint64_t incarnation = 0;  // 0: nobody is watched
    std::string host;
    bool local = false;
    Duration limit{};  // of its silence; 0: no beat is expected
    Time heard{};
    bool probed = false;
    bool forgiven = false;     // the delay was our own, once
    std::optional<Time> look;  // when to look next
    bool work_hung = false;    // by its own word, as against its silence
    Health health = Health::kWell;
    Time starved{};  // when that was noticed last
  };

  static void Promise(MonitoredProcess& process, Duration period);
  void Revive(std::size_t actuator, MonitoredProcess& process, Time now,
              std::vector<Finding>& findings);
  void EvaluateWork(std::size_t actuator, MonitoredProcess& process, const Heartbeat& heartbeat,
                    Time now, std::vector<Finding>& findings);
  void EvaluateRemote(std::size_t actuator, MonitoredProcess& process, Time now,
                      std::vector<Finding>& findings);
  bool HostIsHeard(const MonitoredProcess& process, Time now) const;
  void Change(std::size_t actuator, MonitoredProcess& process, Health health, bool silent,
              std::string how, std::vector<Finding>& findings);

  const MachineConfig* config_;
  std::vector<MonitoredProcess> monitored_;
};

}  // namespace musher
