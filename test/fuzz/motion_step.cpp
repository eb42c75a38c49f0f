// A motion manager and any senders of commands: the checks of motion_fault_test.hpp, from bytes.

#include "musher/test/fuzz/fuzz.hpp"
#include "musher/test/modules/motion/motion_fault_test.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kMostSteps = 150;
  musher::fuzz::Input input(data, size);
  musher::motion::testing::MotionFaultTest trial(
      [&](std::size_t below) { return input.Below(below); });
  const auto broken = trial.Run(static_cast<int>(std::min(kMostSteps, size / 3 + 1)));
  musher::fuzz::Require(!broken, broken.value_or(""));
  return 0;
}
