// An actuator, "arm", whose TearDown calls a library that ends the process with exit code 0. Its
// driver is a global, whose destructor switches the motor off, and says so in the file.

#include <cstdlib>
#include <fstream>

#include "musher/actuator/machine_actuator.hpp"

namespace {

struct Driver {
  ~Driver() {
    if (file != nullptr) std::ofstream(file) << "off";
  }
  const char* file = nullptr;
} driver;

}  // namespace

int main(int, char** words) {
  driver.file = words[1];
  musher::ActuatorRunner<musher::MachineActuator> arm("arm");
  arm.RegisterStateCallback([](const musher::State& state) {
    if (state == musher::kTearDown) std::exit(0);  // NOLINT(concurrency-mt-unsafe)
    return musher::kCodeOk;
  });
  return arm.Run();
}
