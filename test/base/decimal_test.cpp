#include "musher/base/decimal.hpp"

#include <gtest/gtest.h>

namespace musher::decimal_test {

TEST(Decimal, HasTheGivenNumberOfDigits) {
  EXPECT_EQ(Decimal(1.5, 2), "1.50");
  EXPECT_EQ(Decimal(-0.25, 1), "-0.2");
  EXPECT_EQ(Decimal(1234567.0, 0), "1234567");
}

}  // namespace musher::decimal_test
