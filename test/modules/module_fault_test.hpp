#pragma once
// A shipped actuator class in the fault-injection harness, with its topics and services on a
// simulated network whose other node, the desk, has their peers. `Peers` is made from the desk's
// node before each scenario.
//
// The network's time passes while the module waits for its self-check, and in Run().

#include <memory>
#include <optional>
#include <string>

#include "musher/simulation/actuator_fault_test.hpp"
#include "musher/simulation/simulated_node_thread.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::testing {

// Of an actuator with these states, between a less and a more important one: a robot whose module
// has no SelfCheck, which would need more than its peers offer.
inline std::string RobotWithoutSelfCheck(const std::string& actuator) {
  return R"(
[controller]
actuators = ["before", ")" +
         actuator + R"("]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "DeActive", "Protected", "LowPower", "OTA",
          "Error"]
default_time = 2000
default_state = "Uninitialized"

[actuator.before]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "LowPower"]
times = [2000, 1000, 2000, 1000, 1000]
command = ["before"]

[actuator.)" +
         actuator + R"(]
states = ["SetUp", "TearDown", "Active", "DeActive", "Protected", "LowPower", "OTA", "Error"]
times = [2000, 1000, 1000, 1000, 1000, 1000, 1000, 1000]
command = ["module"]
)";
}

template <class Module, class Peers>
class ModuleFaultTest : public simulation::ActuatorFaultTest<Module> {
 public:
  ModuleFaultTest() {
    this->scenarios = 100;
    this->before_scenario = [this] {
      peers.reset();
      desk_.reset();
      network_.emplace(1);
      desk_ = network_->MakeNode("robot");
      peers.emplace(*desk_);
    };
    this->make_node = [this] {
      return std::make_shared<simulation::SimulatedNodeThread>(*network_, "robot");
    };
  }

  void Pass(Duration time) { network_->RunFor(time); }
  // Until it holds; false when it does not within a second.
  bool Await(const std::function<bool()>& holds) {
    return network_->RunUntil(holds, network_->now() + std::chrono::seconds(1));
  }

 private:
  std::optional<transport::sim::Network> network_;
  std::unique_ptr<transport::Node> desk_;

 public:
  std::optional<Peers> peers;
};

}  // namespace musher::testing
