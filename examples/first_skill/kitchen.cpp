// The program of the kettle.

#include "kitchen.hpp"

// [main]
int main() {
  Kitchen kitchen;
  return kitchen.Run();
}
// [main end]
