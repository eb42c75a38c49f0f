// An actuator, "arm", whose TearDown calls a library that ends the process with exit code 0.

#include <cstdlib>

#include "musher/actuator/machine_actuator.hpp"

int main() {
  musher::ActuatorRunner<musher::MachineActuator> arm("arm");
  arm.RegisterStateCallback([](const musher::State& state) {
    if (state == musher::kTearDown) std::exit(0);  // NOLINT(concurrency-mt-unsafe)
    return musher::kCodeOk;
  });
  return arm.Run();
}
