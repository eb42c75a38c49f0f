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
  using Emit = std::function<void(Event)>;
  using Query = std::function<void(ActuatorIndex actuator)>;  // sends it any query

  // All must outlive the watch. `host`: of this controller.
  static Result<std::unique_ptr<HealthWatch>> Make(transport::Node& node,
                                                   const MachineConfig& config,
                                                   ProcessProbe& process_probe, std::string host,
                                                   Emit emit, Query query);

  // The report of the actuator's current process was received just now.
  void OnReport(ActuatorIndex actuator, const ActuatorReport& report);
  // Its process has exited.
  void Forget(ActuatorIndex actuator);

 private:
  HealthWatch(transport::Node& node, const MachineConfig& config, ProcessProbe& process_probe,
              std::string host, Emit emit, Query query);

  void OnHeartbeat(const msg::ActuatorBeat& heartbeat);
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
  HealthMonitor monitor_;
  std::unordered_map<std::string, ActuatorIndex> index_;
  PerActuator<pid_t> pids_;
  std::optional<Time> armed_for_;
  transport::LoopHandlePtr timer_;
  std::unique_ptr<transport::Subscription> heartbeats_;  // last: its callbacks use all of the above
};

}  // namespace musher
