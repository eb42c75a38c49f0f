// The program of the gripper.

#include "gripper.hpp"

// [main]
int main() {
  Gripper gripper;
  if (!gripper.MachineActuatorInit() || !gripper.ActuatorStart()) return 1;
  return gripper.Wait();
}
// [main end]
