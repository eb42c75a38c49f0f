// The program of the door.

#include "door.hpp"

#include <iostream>

// [main]
int main() {
  Door door;
  if (const musher::Result<> ready = door.Prepare(); !ready) {
    std::cerr << ready.error().message << std::endl;
    return 2;
  }
  if (!door.ActuatorStart()) return 1;
  return door.Wait();
}
// [main end]
