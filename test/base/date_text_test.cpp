#include "musher/base/date_text.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>
#include <limits>

namespace musher::date_text_test {

using Time = std::chrono::sys_seconds;

Time At(std::int64_t seconds) {
  return Time(std::chrono::seconds(seconds));
}

class DateText : public ::testing::Test {
 protected:
  DateText() { Zone("XYZ-3"); }  // three hours ahead of UTC
  ~DateText() override { Zone("UTC"); }
  static void Zone(const char* zone) {
    setenv("TZ", zone, 1);
    tzset();
  }
};

TEST_F(DateText, IsInUtcOrInTheLocalZone) {
  EXPECT_EQ(FormatUtc(At(1'795'687'089)), "2026-11-26T09:58:09Z");
  EXPECT_EQ(FormatUtc(At(0), "%Y-%m-%d %H:%M:%S UTC"), "1970-01-01 00:00:00 UTC");
  EXPECT_EQ(FormatLocal(At(1'795'687'089), "%Y-%m-%d %H:%M:%S"), "2026-11-26 12:58:09");
}

TEST_F(DateText, IsThatOfATimeBefore1970Too) {
  EXPECT_EQ(FormatUtc(At(-1)), "1969-12-31T23:59:59Z");
  EXPECT_EQ(FormatUtc(At(-14'182'940)), "1969-07-20T20:17:40Z");
}

TEST_F(DateText, IsThatOfEachSecondOfNanoseconds) {
  EXPECT_EQ(WholeSeconds(1'999'999'999), At(1));
  EXPECT_EQ(WholeSeconds(-1), At(-1));
  EXPECT_EQ(WholeSeconds(-1'000'000'000), At(-1));
  EXPECT_EQ(FormatUtc(WholeSeconds(std::numeric_limits<std::int64_t>::min())),
            "1677-09-21T00:12:43Z");
  EXPECT_EQ(FormatUtc(WholeSeconds(std::numeric_limits<std::int64_t>::max())),
            "2262-04-11T23:47:16Z");
}

TEST_F(DateText, IsTheSecondsOfATimeWhoseYearIsTooLarge) {
  EXPECT_EQ(FormatUtc(At(67'767'976'233'532'799)), "2147483647-12-31T23:59:59Z");
  EXPECT_EQ(FormatUtc(At(67'767'976'233'532'800)), "@67767976233532800");
  EXPECT_EQ(FormatUtc(Time::max()), "@9223372036854775807");
  EXPECT_EQ(FormatUtc(Time::min()), "@-9223372036854775808");
  EXPECT_EQ(FormatLocal(Time::max(), "%H:%M"), "@9223372036854775807");
}

}  // namespace musher::date_text_test
