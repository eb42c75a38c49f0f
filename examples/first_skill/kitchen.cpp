// The program of the kettle.

#include "kitchen.hpp"

int main() {
  Kitchen kitchen;
  return kitchen.Run();
}
