// The program of new_app.

#include "new_app.hpp"

int main() {
  NewApp new_app;
  return new_app.Run();
}
