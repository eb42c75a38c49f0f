#include "musher/base/process_usage.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

namespace musher::process_usage_test {

TEST(ProcessUsage, IsReadFromTheKernelsText) {
  const auto usage = ParseUsage(
      7, "7 (a ) (b) S 1 7 7 0 -1 4194560 1 0 0 0 250 50 0 0 20 0 3 0 1234 9000 21 18446 0", 100,
      4096);
  EXPECT_EQ(usage, (ProcessUsage{7, 1234, 3.0, 21 * 4096, 3}));
}

TEST(ProcessUsage, IsNotReadFromHalfAText) {
  EXPECT_EQ(ParseUsage(7, "7 (a) S 1 7", 100, 4096), std::nullopt);
  EXPECT_EQ(ParseUsage(7, "", 100, 4096), std::nullopt);
}

TEST(ProcessUsage, IsThatOfAProcessThatExists) {
  EXPECT_EQ(UsageOf(0), std::nullopt);
  EXPECT_GT(UsageOf(getpid())->resident_bytes, 0U);
}

}  // namespace musher::process_usage_test
