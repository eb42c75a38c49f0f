#pragma once
// The actuator `plan_dispatcher`. See ../README.md.
//
//   SetUp        the goals that a killed process has left to its robots are cancelled
//   Active       plans are executed
//   all others   the present plan is cancelled, new ones are refused
//   its process could not run for more than a minute: the present plan is cancelled; after more
//                than 5 s new ones are refused for 2 s
//   an emergency stop: the same, until Active is set again after its release
//
// Threads: state callbacks on the actuator's worker, the action and emergency stops on the loop.

#include <memory>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/actuator/program/end_signals.hpp"
#include "musher/modules/skills/plan/plan_server.hpp"

namespace musher::skills {

class DispatcherActuator : public MachineActuator {
 public:
  DispatcherActuator(const std::string& actuator_name, DispatcherConfig config);
  ~DispatcherActuator() override = default;

  // Before Init(): at SIGTERM and SIGINT the present plan is cancelled, then the process ends. They
  // must outlive it.
  void CancelAt(const program::EndSignals& signals) { signals_ = &signals; }

 protected:
  void OnEmergencyStop() override;

 private:
  Result<> Run(const State& state);
  Result<> SetUp();
  void OnEnd();

  const DispatcherConfig config_;
  const program::EndSignals* signals_ = nullptr;
  std::weak_ptr<PlanServer> server_;  // kept by the endpoints
};

}  // namespace musher::skills
