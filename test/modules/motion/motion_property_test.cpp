// What holds for every order of commands, events and times (motion_fault_test.hpp lists it).

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "musher/test/modules/motion/motion_fault_test.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::motion::testing::motion_property_test {

RC_GTEST_PROP(MotionManager, HoldsItsInvariantsUnderRandomEvents, ()) {
  MotionFaultTest trial([](std::size_t below) { return *rc::gen::inRange<std::size_t>(0, below); });
  const auto broken = trial.Run(*rc::gen::inRange(1, 150));
  if (broken) RC_FAIL(*broken);
}

// The same from a plain generator, without shrinking and so a lot more of it.
TEST(MotionManager, HoldsItsInvariantsInManyRandomRuns) {
  for (std::uint64_t seed = 1; seed <= (musher::testing::Nightly() ? 500U : 100U); ++seed) {
    std::uint64_t state = seed;
    MotionFaultTest trial([&](std::size_t below) {
      state = state * 6364136223846793005U + 1442695040888963407U;
      return static_cast<std::size_t>(state >> 33U) % below;
    });
    ASSERT_EQ(trial.Run(200), std::nullopt) << "seed " << seed;
  }
}

}  // namespace musher::motion::testing::motion_property_test
