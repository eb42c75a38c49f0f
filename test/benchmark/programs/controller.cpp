// A controller that brings its machine to Active, says so, and rests:
//
//   benchmark_controller CONFIG

#include <unistd.h>

#include <cstdio>

#include "musher/controller/machine_controller.hpp"
#include "musher/test/benchmark/common/child.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 1;
  musher::benchmark::DieWithParent();
  musher::MachineController controller;
  if (!controller.Init(argv[1]) || !controller.AwaitSetUp() ||
      !controller.Switch("SelfCheck").done() || !controller.Switch("Active").done()) {
    return 1;
  }
  std::puts("Active");
  std::fflush(stdout);
  while (true) pause();
}
