// How fast world time runs.

#include "musher/modules/world/process/pacer.hpp"

#include <gmock/gmock.h>

namespace musher::world::pacer_test {

using ::testing::HasSubstr;
using ::testing::Optional;

constexpr Duration kStep = Milliseconds(20);
constexpr Time kStart = Time{} + std::chrono::hours(1);

// Makes steps until `end`, each `late` after it is due; returns how many.
int StepsUntil(Pacer& pacer, Time end, Duration late = Duration::zero()) {
  int steps = 0;
  Time now = pacer.due();
  while (true) {
    now = std::max(now, pacer.due() + late);
    if (now > end) return steps;
    pacer.Next(now);
    ++steps;
  }
}

TEST(Pacer, MakesAsManyStepsAsItsFactorRequiresWithoutDrift) {
  for (const double factor : {0.5, 1.0, 3.0, 5.0, 20.0}) {
    Pacer pacer(kStep, factor, kStart);
    const int steps = StepsUntil(pacer, kStart + std::chrono::seconds(10), Milliseconds(1));
    EXPECT_NEAR(steps, 500 * factor, 1 + 0.05 * factor) << factor;
    EXPECT_NEAR(pacer.reached(), factor, 0.005 * factor);
    EXPECT_EQ(pacer.TakeLogLine(), std::nullopt);
  }
}

TEST(Pacer, LosesTheTimeItWasKeptFromRunning) {
  Pacer pacer(kStep, 1, kStart);
  StepsUntil(pacer, kStart + std::chrono::seconds(1));
  pacer.Next(kStart + std::chrono::seconds(4));  // three seconds late
  const Time due = pacer.due();
  EXPECT_GE(due, kStart + std::chrono::seconds(4) - Milliseconds(20));
  EXPECT_EQ(StepsUntil(pacer, kStart + std::chrono::seconds(5)), 52);  // from 3.98 to 5.00 s
}

TEST(Pacer, CatchesUpALittleLag) {
  Pacer pacer(kStep, 5, kStart);  // a step each 4 ms
  pacer.Next(kStart + Milliseconds(4));
  EXPECT_EQ(pacer.Next(kStart + Milliseconds(20)), kStart + Milliseconds(12));  // 12 ms late
}

TEST(Pacer, LogsOnceThatItCannotHoldItsFactorAndOnceThatItCanAgain) {
  Pacer pacer(kStep, 5, kStart);
  Time now = kStart;
  std::vector<std::string> lines;
  const auto run = [&](Duration each, int steps) {
    for (int i = 0; i < steps; ++i) {
      now += each;
      pacer.Next(now);
      if (auto line = pacer.TakeLogLine()) lines.push_back(*line);
    }
  };
  run(Milliseconds(8), 3000);  // 24 s
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_THAT(lines[0], HasSubstr("2.50 times as fast as real time instead of 5.00"));
  EXPECT_NEAR(pacer.reached(), 2.5, 0.01);
  run(Milliseconds(4), 3000);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_THAT(lines[1], HasSubstr("again"));
}

TEST(Pacer, DoesNotTreatAPauseAsSlowness) {
  Pacer pacer(kStep, 1, kStart);
  StepsUntil(pacer, kStart + std::chrono::seconds(2));
  pacer.SetPaused(true, kStart + std::chrono::seconds(2));
  pacer.SetPaused(false, kStart + std::chrono::seconds(60));
  EXPECT_EQ(StepsUntil(pacer, kStart + std::chrono::seconds(70)), 500);
  EXPECT_EQ(pacer.TakeLogLine(), std::nullopt);
  EXPECT_NEAR(pacer.reached(), 1, 0.01);
}

}  // namespace musher::world::pacer_test
