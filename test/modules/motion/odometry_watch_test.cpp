// When musher-motion reports missing odometry.

#include "musher/modules/motion/tool/odometry_watch.hpp"

#include <gtest/gtest.h>

namespace musher::motion::tool::odometry_watch_test {

constexpr Time kBegin{std::chrono::hours(1)};
constexpr Duration kFrame = Milliseconds(50);

// Checks with every frame; returns when it is reported missing, at most a minute later.
Duration MissedAfter(OdometryWatch& watch, Time begin) {
  Time now = begin;
  while (!watch.Missing(now) && now - begin < std::chrono::minutes(1)) now += kFrame;
  return now - begin;
}

TEST(OdometryWatch, WaitsForTheFirstSampleAsLongAsConfigured) {
  OdometryWatch watch(kBegin, std::chrono::seconds(20));
  const Duration missed = MissedAfter(watch, kBegin);
  EXPECT_GT(missed, std::chrono::seconds(20));
  EXPECT_LE(missed, std::chrono::seconds(20) + 2 * kFrame);
}

TEST(OdometryWatch, WaitsFiveSecondsForTheNext) {
  OdometryWatch watch(kBegin, std::chrono::seconds(20));
  watch.OnSample(kBegin);
  const Duration missed = MissedAfter(watch, kBegin);
  EXPECT_GT(missed, std::chrono::seconds(5));
  EXPECT_LE(missed, std::chrono::seconds(5) + 2 * kFrame);
}

TEST(OdometryWatch, IsTooOldToWalkByAfterHalfASecond) {
  OdometryWatch watch(kBegin, std::chrono::seconds(20));
  watch.OnSample(kBegin);
  EXPECT_FALSE(watch.Old(kBegin + Milliseconds(500)));
  EXPECT_TRUE(watch.Old(kBegin + Milliseconds(501)));
  watch.OnSample(kBegin + Milliseconds(600));
  EXPECT_FALSE(watch.Old(kBegin + Milliseconds(601))) << "it walks on";
}

TEST(OdometryWatch, DoesNotReportQueuedSamplesAsMissingAfterALateTurn) {
  OdometryWatch watch(kBegin, std::chrono::seconds(20));
  watch.OnSample(kBegin);
  Time now = kBegin;
  for (int stalls = 0; stalls < 3; ++stalls) {
    now += std::chrono::seconds(8);
    EXPECT_FALSE(watch.Missing(now)) << "the timer comes first";
    watch.OnSample(now);
    EXPECT_FALSE(watch.Missing(now += kFrame));
  }
}

}  // namespace musher::motion::tool::odometry_watch_test
