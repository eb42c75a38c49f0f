#include "musher/lifecycle/actuator/battery_reading.hpp"

#include <gtest/gtest.h>

namespace musher::testing::battery_reading_test {

using std::chrono::seconds;

constexpr Duration kRaiseAfter = seconds(5);
constexpr Duration kSilent = seconds(10);

class BatteryReadings : public ::testing::Test {
 protected:
  // A sample, a second after the one before.
  int Take(int percent, std::uint64_t publisher = 1) {
    now_ += seconds(1);
    return reading_.Take(publisher, percent, now_);
  }

  Time now_{};
  BatteryReading reading_{kRaiseAfter, kSilent};
};

TEST_F(BatteryReadings, BeginWithTheFirstSample) {
  EXPECT_EQ(Take(64), 64);
}

TEST_F(BatteryReadings, FollowALowerSampleAtOnce) {
  Take(64);
  EXPECT_EQ(Take(20), 20);
}

TEST_F(BatteryReadings, IgnoreOneHighSampleAmongLowOnes) {
  Take(10);
  EXPECT_EQ(Take(80), 10);
  EXPECT_EQ(Take(10), 10);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(Take(i % 2 == 0 ? 80 : 10), 10);
}

TEST_F(BatteryReadings, FollowHigherSamplesThatLast) {
  Take(10);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(Take(80 + i), 10);
  EXPECT_EQ(Take(85), 80) << "the lowest of those that confirm it";
}

TEST_F(BatteryReadings, AreOfTheLowestPublisherUntilItIsSilent) {
  Take(80, 1);
  EXPECT_EQ(Take(15, 2), 15);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(Take(80, 1), 15);
  for (int i = 0; i < 6; ++i) Take(80, 1);
  EXPECT_EQ(Take(80, 1), 80);
}

TEST_F(BatteryReadings, BeginAgainAfterSilence) {
  Take(10);
  reading_.Forget();
  EXPECT_EQ(Take(80), 80);
}

}  // namespace musher::testing::battery_reading_test
