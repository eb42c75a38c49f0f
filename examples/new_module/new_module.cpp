// The program of new_module.

#include "new_module.hpp"

int main() {
  NewModule new_module;
  return new_module.Run();
}
