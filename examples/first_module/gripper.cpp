// The program of the gripper.

#include "gripper.hpp"

// [main]
int main() {
  Gripper gripper;
  return gripper.Run();
}
// [main end]
