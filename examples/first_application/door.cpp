// The program of the door.

#include "door.hpp"

// [main]
int main() {
  Door door;
  if (!door.MachineActuatorInit() || !door.ActuatorStart()) return 1;
  return door.Wait();
}
// [main end]
