#include "musher/lifecycle/health/health.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>

namespace musher::health_test {

constexpr Duration kAllowed = Milliseconds(100);

TEST(Silence, IsWellWithinTheAllowance) {
  EXPECT_EQ(EvaluateSilence(Milliseconds(99), kAllowed, {}), Health::kWell);
  EXPECT_EQ(EvaluateSilence(Milliseconds(100), kAllowed, {}), Health::kWell);
}

TEST(Silence, BeyondTheAllowanceIsAHangOfAProcessThatCouldRun) {
  EXPECT_EQ(EvaluateSilence(Milliseconds(101), kAllowed, {}), Health::kHung);
  EXPECT_EQ(EvaluateSilence(Milliseconds(200), kAllowed, Milliseconds(99)), Health::kHung);
}

TEST(Silence, OfAProcessThatWaitedForACpuDoesNotCount) {
  EXPECT_EQ(EvaluateSilence(Milliseconds(200), kAllowed, Milliseconds(100)), Health::kStarved);
  EXPECT_EQ(EvaluateSilence(std::chrono::hours(1), kAllowed, std::chrono::hours(1)),
            Health::kStarved);
}

TEST(Silence, HasANameForEachHealth) {
  EXPECT_EQ(HealthName(Health::kWell), "well");
  EXPECT_EQ(HealthName(Health::kStarved), "starved");
  EXPECT_EQ(HealthName(Health::kHung), "hung");
  EXPECT_EQ(HealthName(Health::kCrashed), "crashed");
  EXPECT_EQ(HealthName(Health::kPartitioned), "partitioned");
}

Duration AnyDuration() {
  return Milliseconds(*rc::gen::inRange(0, 100'000));
}

RC_GTEST_PROP(SilenceProperty, WaitingLongerForACpuNeverMakesTheVerdictWorse, ()) {
  const Duration silent = AnyDuration();
  const Duration allowance = AnyDuration();
  Duration less = AnyDuration();
  Duration more = AnyDuration();
  if (less > more) std::swap(less, more);
  RC_ASSERT(EvaluateSilence(silent, allowance, more) <= EvaluateSilence(silent, allowance, less));
}

RC_GTEST_PROP(SilenceProperty, LongerSilenceNeverMakesTheVerdictBetter, ()) {
  const Duration allowance = AnyDuration();
  const Duration waited = AnyDuration();
  Duration less = AnyDuration();
  Duration more = AnyDuration();
  if (less > more) std::swap(less, more);
  RC_ASSERT(EvaluateSilence(less, allowance, waited) <= EvaluateSilence(more, allowance, waited));
}

}  // namespace musher::health_test
