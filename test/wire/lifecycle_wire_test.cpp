#include "musher/wire/lifecycle_wire.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace musher::transport::lifecycle_wire_test {

ActuatorReport Stamped(std::int64_t stamp_ns) {
  msg::ActuatorStatus status;
  status.stamp_ns = stamp_ns;
  return FromMessage(status);
}

TEST(LifecycleWire, KeepsTheStampOfAClock) {
  const Time now(std::chrono::hours(24 * 365 * 10));
  EXPECT_EQ(Stamped(ToNanoseconds(now)).stamp, now);
}

TEST(LifecycleWire, ClampsAStampThatIsOutOfRange) {
  const Time now(std::chrono::hours(24 * 365 * 10));
  EXPECT_LT(Stamped(INT64_MIN).stamp - now, Duration::zero());
  EXPECT_GT(Stamped(INT64_MAX).stamp - now + std::chrono::hours(1), Duration::zero());
}

}  // namespace musher::transport::lifecycle_wire_test
