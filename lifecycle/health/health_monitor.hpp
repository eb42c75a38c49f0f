#pragma once
// Monitors the liveliness of actuators from what is received from them. Pure: its inputs are
// samples and the time; its outputs say which actuator to probe, which process to examine, and
// whose health has changed.
//
//   received ──▶ silent for half its limit: it is probed (Probe), and the kernel's counters of its
//     ▲          process are taken as a mark (Examine) where that is possible
//     │                    │
//     └── received again ──┤ silent for its limit
//                          ▼
//          on this host:    Examine ──▶ waited for CPU or disk: starved   else, or stopped: hung
//          on another host: its other actuators are received ──▶ crashed   none is ──▶ partitioned
//
// The exit of a process is not handled here: the kernel reports it at once. A program of another
// protocol without heartbeats is never evaluated, except a ROS 2 node with a checkpoint, which
// answers queries.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/health/health.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/lifecycle/per_actuator.hpp"

namespace musher {

// The heartbeat period of an actuator: half of `checkpoint_ms`, at most 500 ms. With several hosts
// at most 125 ms, since nothing else reports an exit on another host. An actuator is silent once it
// has missed three heartbeats in a row.
Duration HeartbeatPeriod(const MachineConfig& config, ActuatorIndex actuator);
// The heartbeat period of a controller.
Duration ControllerHeartbeatPeriod(const MachineConfig& config);

// What an actuator reports about itself.
struct Heartbeat {
  Duration period{};            // until the next one
  Health work = Health::kWell;  // of its work thread: well, starved or hung
  State during;                 // the state whose callback runs; empty for work of its own
  Duration silent{};            // since the work thread's last checkpoint
  Duration waited{};  // of `silent`, the time that the thread waited for a CPU or the disk
};

// What the kernel reports about a process of this host.
struct Examination {
  enum class Process { kRunning, kStopped, kTraced, kExited };

  Process process = Process::kRunning;
  Duration waited{};   // the longest wait for a CPU since the mark, of that process or of ours
  Duration on_disk{};  // and for the disk, beside that
};

namespace health_event {
// Send it a query: an actuator that answers is alive.
struct Probe {
  ActuatorIndex actuator = 0;
};
// Examine its process; with `mark`, keep the result to measure from.
struct Examine {
  ActuatorIndex actuator = 0;
  bool mark = false;
};
struct Changed {
  ActuatorIndex actuator = 0;
  Incarnation incarnation = 0;
  Health health = Health::kWell;
  bool silent = false;  // it does not answer either
  std::string how;      // "no heartbeat for 512 ms"
};
}  // namespace health_event

using HealthEvent = std::variant<health_event::Probe, health_event::Examine, health_event::Changed>;

class HealthMonitor {
 public:
  explicit HealthMonitor(const MachineConfig& config);

  // Monitors an actuator from now on. `local`: the kernel can be queried about its process.
  void Watch(ActuatorIndex actuator, Incarnation incarnation, const std::string& host, bool local,
             Time now);
  // Its process has exited.
  void Forget(ActuatorIndex actuator);

  // A sample of the actuator arrived: a status, or an answer.
  std::vector<HealthEvent> OnSample(ActuatorIndex actuator, Incarnation incarnation, Time now);
  std::vector<HealthEvent> OnSample(ActuatorIndex actuator, Incarnation incarnation,
                                    const Heartbeat& heartbeat, Time now);
  std::vector<HealthEvent> Examined(ActuatorIndex actuator, const Examination& examination,
                                    Time now);
  std::vector<HealthEvent> TimePassed(Time now);

  std::optional<Time> NextDeadline() const;

 private:
  struct MonitoredProcess {
    Incarnation incarnation = 0;  // 0: not monitored
    std::string host;
    bool local = false;
    Duration limit{};  // of its silence; 0: no heartbeat is expected
    Time last_received{};
    bool probed = false;
    bool excused = false;      // a late loop of the controller was excused, once
    std::optional<Time> look;  // when to examine next
    bool work_hung = false;    // by the last heartbeat, not by silence
    Health health = Health::kWell;
    bool silent = false;  // so it was reported
    Time starved{};       // when that was last observed
  };

  static void SetLimit(MonitoredProcess& process, Duration period);
  void Revive(ActuatorIndex actuator, MonitoredProcess& process, Time now,
              std::vector<HealthEvent>& events);
  void NoteBreak(const MonitoredProcess& process, Time now);
  void EvaluateWork(ActuatorIndex actuator, MonitoredProcess& process, const Heartbeat& heartbeat,
                    Time now, std::vector<HealthEvent>& events);
  void EvaluateRemote(ActuatorIndex actuator, MonitoredProcess& process, Time now,
                      std::vector<HealthEvent>& events);
  bool HostIsAlive(const MonitoredProcess& process, Time now) const;
  void Change(ActuatorIndex actuator, MonitoredProcess& process, Health health, bool silent,
              std::string how, std::vector<HealthEvent>& events);

  const MachineConfig* config_;
  PerActuator<MonitoredProcess> monitored_;
  Time no_silence_until_{};  // counts, after a break of the controller's own
};

}  // namespace musher
