#include "musher/base/check.hpp"

#include <gtest/gtest.h>

namespace musher::check_test {

TEST(CheckDeathTest, EndsTheProgramWithThePlaceTheConditionAndTheValues) {
  const int legs = 3;
  EXPECT_DEATH(
      MUSHER_CHECK(legs == 4, "legs", legs),
      "^test/base/check_test.cpp:[0-9]+: a check failed: legs == 4 .legs 3.; this is a bug\n");
}

TEST(CheckDeathTest, AddsWhatTheThreadIsDoing) {
  const auto fail = [] {
    const CheckContext robot("robot 7");
    const CheckContext step("step 12");
    MUSHER_CHECK(false);
  };
  EXPECT_DEATH(fail(), "a check failed: false, in step 12, in robot 7");
}

TEST(Check, EvaluatesTheConditionOnceAndTheValuesOnlyWhenItIsFalse) {
  int conditions = 0;
  int values = 0;
  MUSHER_CHECK(++conditions > 0, ++values);
  EXPECT_EQ(conditions, 1);
  EXPECT_EQ(values, 0);
}

}  // namespace musher::check_test
