// Two actuators, "arm" and "leg", in one process with one participant. It ends when both have been
// torn down.

#include <cstdlib>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/transport/dds/node_thread.hpp"

int main() {
  const std::shared_ptr<musher::transport::NodeThread> node =
      musher::transport::NodeThread::Start().value();
  using Actuator = musher::ActuatorRunner<musher::MachineActuator>;
  Actuator arm("arm");
  Actuator leg("leg");
  for (Actuator* actuator : {&arm, &leg}) {
    actuator->RegisterStateCallback([](const musher::State&) { return musher::kCodeOk; });
    const auto begun = actuator->Init("", node);
    const auto started = begun ? actuator->Start() : begun;
    if (!started) {
      actuator->Log(started.error());
      return EXIT_FAILURE;
    }
  }
  return arm.Wait() | leg.Wait();
}
