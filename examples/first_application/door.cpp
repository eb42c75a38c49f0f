// The program of the door.

#include "door.hpp"

// [main]
int main() {
  Door door;
  return door.Run();
}
// [main end]
