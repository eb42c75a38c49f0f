#pragma once
// The actuator `meilin_planner`. See README.md in this folder.
//
//   Active       plans are sent and handed out
//   all others   maps are planned, but no plan leaves it
//   an emergency stop: the same, until Active is set again after its release
//
// Threads: state callbacks on the actuator's worker, topics and emergency stops on the loop.

#include <memory>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/modules/meilin/plan/planner_endpoint.hpp"
#include "musher/transport/clock.hpp"

namespace musher::meilin {

class PlannerActuator : public MachineActuator {
 public:
  PlannerActuator(const std::string& actuator_name, PlannerConfig config);
  ~PlannerActuator() override;

 protected:
  void OnEmergencyStop() override;

 private:
  Result<> Run(const State& state);
  Result<> SetUp();
  Result<> Open();

  const PlannerConfig config_;
  std::shared_ptr<transport::NodeThread> node_;  // from SetUp on
  std::unique_ptr<transport::Clock> clock_;
  std::unique_ptr<PlannerEndpoint> endpoint_;
};

}  // namespace musher::meilin
