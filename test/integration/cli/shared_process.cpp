// Two actuators, "arm" and "leg", in one process with one participant. It ends when one of them has
// been torn down.

#include <cstdlib>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/transport/dds/node_thread.hpp"

int main() {
  const std::shared_ptr<musher::transport::NodeThread> node =
      musher::transport::NodeThread::Start().value();
  musher::MachineActuator arm("arm");
  musher::MachineActuator leg("leg");
  for (musher::MachineActuator* actuator : {&arm, &leg}) {
    actuator->RegisterStateCallback([](const musher::State&) { return musher::kCodeOk; });
    if (!actuator->MachineActuatorInit("", node) || !actuator->ActuatorStart()) {
      return EXIT_FAILURE;
    }
  }
  return arm.Wait() | leg.Wait();
}
