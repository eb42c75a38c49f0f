// The program of the desk.

#include "desk.hpp"

int main() {
  Desk desk;
  return desk.Run();
}
