#pragma once
// The actuator `yellow_line_walker`. See README.md in this folder.
//
//   Active       START begins a walk
//   all others   a walk ends, START is refused
//   an emergency stop: the same, until Active is set again after its release
//
// Threads: state callbacks on the actuator's worker, topics and emergency stops on the loop.

#include <memory>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/modules/line_walker/walker_config.hpp"
#include "musher/modules/line_walker/walker_topics.hpp"
#include "musher/transport/clock.hpp"

namespace musher::line_walker {

class WalkerActuator : public MachineActuator {
 public:
  WalkerActuator(const std::string& actuator_name, WalkerConfig config);
  ~WalkerActuator() override;

 protected:
  void OnEmergencyStop() override;

 private:
  Result<> Run(const State& state);
  Result<> SetUp();
  Result<> SelfCheck();
  Result<> Enter(const State& state);
  Result<> MakeTopics();

  const WalkerConfig config_;
  std::shared_ptr<transport::NodeThread> node_;  // from SetUp on
  std::unique_ptr<transport::Clock> clock_;
  std::unique_ptr<WalkerTopics> topics_;
};

}  // namespace musher::line_walker
