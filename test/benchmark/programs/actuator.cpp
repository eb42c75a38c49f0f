// Actuators whose callbacks do nothing:
//
//   benchmark_actuator NAME...
//
// Several names are actuators that share the process and its participant.

#include <memory>
#include <vector>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/transport/dds/node_thread.hpp"

int main(int argc, char** argv) {
  using Actuator = musher::ActuatorRunner<musher::MachineActuator>;
  musher::benchmark::DieWithParent();
  std::shared_ptr<musher::transport::NodeThread> node;
  if (argc > 2) node = musher::transport::NodeThread::Start().value();
  std::vector<std::unique_ptr<Actuator>> actuators;
  for (int i = 1; i < argc; ++i) {
    Actuator& actuator = *actuators.emplace_back(std::make_unique<Actuator>(argv[i]));
    actuator.RegisterStateCallback([](const musher::State&) { return 0; });
    const auto begun = actuator.Init("", node);
    const auto started = begun ? actuator.Start() : begun;
    if (!started) {
      actuator.Log(started.error());
      return 1;
    }
  }
  for (const auto& actuator : actuators) actuator->Wait();
}
