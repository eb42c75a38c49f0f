#include "musher/modules/sensor/readings.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "musher/test/modules/sensor/examples.hpp"

namespace musher::sensor::readings_test {

using std::chrono::seconds;
using ::testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(Readings, OfAWorkingSensorAreValid) {
  EXPECT_TRUE(Validate(ScanOf(3)));
  EXPECT_TRUE(Validate(RangeOf(0.5F)));
  EXPECT_TRUE(Validate(TofOf(2), 2));
  EXPECT_TRUE(Validate(FixOf(40, 116)));
}

TEST(Readings, MayReportThatNothingIsNearOrThatItIsTooNear) {
  for (const float reading : {kInfinity, -kInfinity}) {
    EXPECT_TRUE(Validate(ScanOf(reading)));
    EXPECT_TRUE(Validate(RangeOf(reading)));
    msg::SingleTofPayload tof = TofOf(0);
    tof.data[63] = reading;
    EXPECT_TRUE(Validate(tof, 0));
  }
}

TEST(Readings, ThatAreNanOrNegativeAreRefused) {
  for (const float reading : {kNan, -0.5F}) {
    msg::LaserScan scan = ScanOf(3);
    scan.ranges[7] = reading;
    EXPECT_THAT(Validate(scan).error().message, HasSubstr("distance 7 is"));
    EXPECT_FALSE(Validate(RangeOf(reading)));
    msg::SingleTofPayload tof = TofOf(0);
    tof.data[63] = reading;
    EXPECT_THAT(Validate(tof, 0).error().message, HasSubstr("distance 63 is"));
  }
  EXPECT_FALSE(Validate(FixOf(kNan, 116)));
  EXPECT_FALSE(Validate(FixOf(91, 116)));
  EXPECT_FALSE(Validate(FixOf(40, -181)));
}

TEST(Readings, OfAWrongLengthAreRefused) {
  msg::LaserScan scan = ScanOf(3);
  scan.ranges.clear();
  EXPECT_THAT(Validate(scan).error().message, HasSubstr("0 rays"));
  scan = ScanOf(3);
  scan.ranges.resize(90);
  EXPECT_THAT(Validate(scan).error().message, HasSubstr("are not those of 90 rays"));
  scan = ScanOf(3);
  scan.intensities.resize(5);
  EXPECT_THAT(Validate(scan).error().message, HasSubstr("181 rays and 5 intensities"));
  msg::SingleTofPayload tof = TofOf(1);
  tof.data.pop_back();
  EXPECT_THAT(Validate(tof, 1).error().message, HasSubstr("63 zones"));
  tof = TofOf(1);
  tof.intensity.push_back(0);
  EXPECT_THAT(Validate(tof, 1).error().message, HasSubstr("65 intensities"));
}

TEST(Readings, OfADriverThatDoesNotCountItsLastRayCount) {
  msg::LaserScan scan = ScanOf(3);
  scan.ranges.pop_back();
  EXPECT_TRUE(Validate(scan));
}

TEST(Readings, WithImpossibleLimitsAreRefused) {
  msg::LaserScan scan = ScanOf(3);
  scan.range_max = kNan;
  EXPECT_FALSE(Validate(scan));
  scan = ScanOf(3);
  scan.angle_increment = 0;
  EXPECT_FALSE(Validate(scan));
  scan.angle_increment = kInfinity;
  EXPECT_FALSE(Validate(scan));
  msg::Range range = RangeOf(0.5F);
  range.min_range = 3;
  EXPECT_FALSE(Validate(range));
}

TEST(Readings, OfAnotherTofThanTheirTopicsAreRefused) {
  EXPECT_THAT(Validate(TofOf(1), 0).error().message, HasSubstr("position 1, not 0"));
  msg::SingleTofPayload tof = TofOf(1);
  tof.data_available = false;
  EXPECT_FALSE(Validate(tof, 1));
}

TEST(Readings, WithoutAFixMayHaveNoPosition) {
  msg::NavSatFix fix = FixOf(kNan, kNan);
  fix.status.status = msg::NavSatStatus::kNoFix;
  EXPECT_TRUE(Validate(fix));
  const msg::GpsPayload payload = ToGpsPayload(fix);
  EXPECT_EQ(payload.fix_type, 0);
  EXPECT_EQ(payload.lat, 0);
  fix.status.status = 9;
  EXPECT_FALSE(Validate(fix));
}

TEST(Stamps, NearToNowCountAndOthersDoNot) {
  StampChecker checker(Milliseconds(500));
  EXPECT_TRUE(checker.Take(seconds(10), seconds(10)));
  EXPECT_TRUE(checker.Take(seconds(11), seconds(11) - Milliseconds(500)));
  EXPECT_THAT(checker.Take(seconds(13), seconds(12)).error().message, HasSubstr("1 s ahead"));
  EXPECT_THAT(checker.Take(seconds(12), seconds(14)).error().message, HasSubstr("2 s old"));
  EXPECT_TRUE(checker.Take(seconds(12), seconds(12))) << "what was refused left no trace";
}

TEST(Stamps, NeverGoBackUnlessTimeDoes) {
  StampChecker checker(Duration::zero());
  EXPECT_TRUE(checker.Take(seconds(10), seconds(500)));
  EXPECT_FALSE(checker.Take(seconds(10), seconds(500)));
  EXPECT_FALSE(checker.Take(seconds(9), seconds(500)));
  checker.Forget();
  EXPECT_TRUE(checker.Take(seconds(1), seconds(500)));
}

// By a time server, after hours of a clock that was ahead.
TEST(Stamps, CountAfterTheTimeOfTheComputerWasSetBack) {
  StampChecker checker(Milliseconds(500));
  EXPECT_TRUE(checker.Take(seconds(36'000), seconds(36'000)));
  EXPECT_TRUE(checker.Take(seconds(7'200), seconds(7'200)));
  EXPECT_FALSE(checker.Take(seconds(7'200), seconds(7'200)));
  EXPECT_FALSE(checker.Take(seconds(36'001), seconds(7'201)));
}

int Passed(RateLimit limit, double source_hz, int readings) {
  int passed = 0;
  for (int i = 0; i < readings; ++i) {
    const std::chrono::duration<double> at(100 + i / source_hz);
    if (limit.Take(std::chrono::duration_cast<Duration>(at))) ++passed;
  }
  return passed;
}

TEST(RateOfReadings, IsTheConfiguredOneAtAnyRateOfTheSource) {
  const RateLimit ten(Milliseconds(100));
  EXPECT_EQ(Passed(ten, 10, 100), 100);
  EXPECT_NEAR(Passed(ten, 15, 150), 100, 2);
  EXPECT_NEAR(Passed(ten, 50, 500), 100, 2);
  EXPECT_EQ(Passed(ten, 4, 40), 40);
  EXPECT_EQ(Passed(RateLimit(Duration::zero()), 50, 500), 500);
}

RC_GTEST_PROP(RateOfReadingsProperty, IsNeverMuchHigherThanTheConfiguredOne, ()) {
  const auto gaps = *rc::gen::container<std::vector<int>>(200, rc::gen::inRange(1, 300));
  RateLimit limit(Milliseconds(100));
  Duration at = seconds(50);
  const Duration begin = at;
  int passed = 0;
  for (const int gap : gaps) {
    at += Milliseconds(gap);
    if (limit.Take(at)) ++passed;
  }
  RC_ASSERT(passed <= (at - begin) / Milliseconds(90) + 1);
}

TEST(RateOfReadings, BeginsAgainWhereTimeWentBack) {
  RateLimit limit(Milliseconds(100));
  EXPECT_TRUE(limit.Take(seconds(100)));
  EXPECT_TRUE(limit.Take(seconds(5)));
  EXPECT_FALSE(limit.Take(seconds(5) + Milliseconds(50)));
}

TEST(Tofs, ArePublishedTogether) {
  TofPair pair(2);
  EXPECT_FALSE(pair.Take(TofOf(3)));
  const auto both = pair.Take(TofOf(2));
  ASSERT_TRUE(both);
  EXPECT_EQ((*both)[0], TofOf(2));
  EXPECT_EQ((*both)[1], TofOf(3));
  EXPECT_FALSE(pair.Take(TofOf(2)));
}

TEST(Tofs, ArePublishedAloneWhenTheOtherIsSilent) {
  TofPair pair(0);
  EXPECT_FALSE(pair.Take(TofOf(0, 1)));
  const auto both = pair.Take(TofOf(0, 2));
  ASSERT_TRUE(both);
  EXPECT_EQ((*both)[0], TofOf(0, 1));
  EXPECT_FALSE((*both)[1].data_available);
  EXPECT_EQ((*both)[1].tof_position, 1);
  EXPECT_THAT((*both)[1].data, ::testing::IsEmpty());
  EXPECT_EQ((*both)[1].header.stamp, TofOf(0, 1).header.stamp);
  // The other is back.
  const auto again = pair.Take(TofOf(1, 2));
  ASSERT_TRUE(again);
  EXPECT_EQ((*again)[0], TofOf(0, 2));
  pair.Forget();
  EXPECT_FALSE(pair.Take(TofOf(1, 3)));
}

TEST(Gps, ReportsTimeAndPlaceAsCyberDogDoes) {
  msg::NavSatFix fix = FixOf(40.25, 116.5);
  // Sunday 2023-10-01 00:00:00 UTC: 18 leap seconds after a GPS week began.
  fix.header.stamp = {1'696'118'400, 250'000'000};
  const msg::GpsPayload payload = ToGpsPayload(fix);
  EXPECT_EQ(payload.sec, 1'696'118'400U);
  EXPECT_EQ(payload.nanosec, 250'000'000U);
  EXPECT_EQ(payload.itow, 18'250U);
  EXPECT_EQ(payload.fix_type, 3);
  EXPECT_EQ(payload.lat, 40.25);
  EXPECT_EQ(payload.lon, 116.5);
  fix.header.stamp = {3, 0};  // a world's time is before the GPS's
  EXPECT_LT(ToGpsPayload(fix).itow, 604'800'000U);
}

}  // namespace musher::sensor::readings_test
