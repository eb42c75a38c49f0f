// The program of the gripper.

#include "gripper.hpp"

#include <iostream>

int main(int argc, char** argv) {
  const auto config = ReadGripper(argc > 1 ? argv[1] : "gripper.toml");
  if (!config) {
    std::cerr << config.error().message << std::endl;
    return 2;
  }
  Gripper gripper(config.value());
  return gripper.Run();
}
