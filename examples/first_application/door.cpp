// The program of the door.

#include "door.hpp"

int main() {
  Door door;
  return door.Run();
}
