#pragma once
// The I/O around the health monitor (lifecycle/health/health_monitor.hpp): subscribes to the
// actuators' heartbeats, examines processes, and emits the results as event::HealthChanged.
//
// Threads: loop thread only.

#include <functional>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "musher/controller/process/process_probe.hpp"
#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/lifecycle/health/health_monitor.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/transport/node.hpp"

namespace musher {

class HealthWatch {
 public:
  using Emit = std::function<void(const event::HealthChanged&)>;
  using Query = std::function<void(ActuatorIndex actuator)>;  // sends it any query
  // A heartbeat of its process was received, which reports that the work thread makes progress.
  using OnAlive = std::function<void(ActuatorIndex actuator, Incarnation incarnation)>;

  // All must outlive the watch. `host`: of this controller.
  static Result<std::unique_ptr<HealthWatch>> Make(transport::Node& node,
                                                   const MachineConfig& config,
                                                   ProcessProbe& process_probe, std::string host,
                                                   Emit emit, Query query, OnAlive on_alive);

  // The report of the actuator's current process was received just now. `participant`: of the
  // process, whose heartbeats alone count from now on; 0: not known.
  void OnReport(ActuatorIndex actuator, const ActuatorReport& report,
                transport::ParticipantId participant);
  // Its process has exited.
  void Forget(ActuatorIndex actuator);
  // A process of it has exited, and the machine has handled that: `known` is what it knows since.
  // Where another process is in use, that one is monitored further.
  void ForgetUnlessPresent(ActuatorIndex actuator, const KnownActuator& known);

 private:
  HealthWatch(transport::Node& node, const MachineConfig& config, ProcessProbe& process_probe,
              std::string host, Emit emit, Query query, OnAlive on_alive);

  void OnHeartbeat(const msg::ActuatorHeartbeat& heartbeat, transport::ParticipantId sender);
  void Act(const std::vector<HealthEvent>& events);
  void Do(const health_event::Probe& f);
  void Do(const health_event::Examine& f);
  void Do(const health_event::Changed& f);
  void ArmTimer();

  transport::Node& node_;
  ProcessProbe& process_probe_;
  const std::string host_;
  const Emit emit_;
  const Query query_;
  const OnAlive on_alive_;
  HealthMonitor monitor_;
  std::unordered_map<std::string, ActuatorIndex> index_;
  struct Watched {
    pid_t pid = 0;
    transport::ParticipantId participant = 0;
  };
  PerActuator<Watched> watched_;
  std::optional<Time> armed_for_;
  transport::LoopHandlePtr timer_;
  std::unique_ptr<transport::Subscription> heartbeats_;  // last: its callbacks use all of the above
};

}  // namespace musher
