#include "musher/cli/console/wall_time.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>

namespace musher::cli::wall_time_test {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kNoon = 1'772'366'405 * kSecond + 250'000'000;  // 2026-03-01T12:00:05.25Z

class WallTime : public ::testing::Test {
 protected:
  WallTime() { Zone("XYZ-3"); }  // three hours ahead of UTC
  ~WallTime() override { Zone("UTC"); }
  static void Zone(const char* zone) {
    setenv("TZ", zone, 1);
    tzset();
  }
  static std::int64_t Since(const std::string& text) {
    const auto since = ParseSince(text, kNoon);
    return since ? since.value() : -1;
  }
};

TEST_F(WallTime, IsWrittenInUtcForProgramsAndLocallyForPeople) {
  EXPECT_EQ(UtcText(kNoon), "2026-03-01T12:00:05.250Z");
  EXPECT_EQ(LocalText(kNoon), "2026-03-01 15:00:05.250");
  EXPECT_EQ(LocalTime(kNoon), "15:00:05.250");
}

TEST_F(WallTime, IsReadAsHowLongAgo) {
  EXPECT_EQ(Since("90s"), kNoon - 90 * kSecond);
  EXPECT_EQ(Since("10m"), kNoon - 600 * kSecond);
  EXPECT_EQ(Since("2h"), kNoon - 7200 * kSecond);
  EXPECT_EQ(Since("1d"), kNoon - 86400 * kSecond);
}

TEST_F(WallTime, IsReadAsADateInTheLocalZoneOrTheOneGiven) {
  EXPECT_EQ(Since("2026-03-01T12:00:05.25Z"), kNoon);
  EXPECT_EQ(Since("2026-03-01T14:00:05.25+02:00"), kNoon);
  EXPECT_EQ(Since("2026-03-01T15:00:05.25"), kNoon);
  EXPECT_EQ(Since("2026-03-01 15:00:05"), kNoon - kSecond / 4);
  EXPECT_EQ(Since("2026-03-01T15:00"), kNoon - 5 * kSecond - kSecond / 4);
  EXPECT_EQ(UtcText(Since("2026-03-01")), "2026-02-28T21:00:00.000Z");
}

TEST_F(WallTime, IsRefusedWhenItIsNone) {
  for (const char* wrong :
       {"", "10", "m", "-5m", "10 m", "yesterday", "2026-13-01", "2026-02-29", "2026-02-30Z",
        "2026-03-01T", "2026-03-01Tx", "2026-03-01T12:00 +", "99999999999999d",
        "99999999999999999999s", "2026-03-01T12:00:00Zjunk"}) {
    EXPECT_EQ(Since(wrong), -1) << wrong;
  }
}

TEST_F(WallTime, IsRefusedWhenNanosecondsDoNotReachSoFar) {
  for (const char* far : {"0226-03-01", "9999-12-31T23:59:59Z", "2300-01-01T00:00+01:00"}) {
    EXPECT_EQ(Since(far), -1) << far;
  }
}

TEST_F(WallTime, Before1970IsWrittenAsItIsRead) {
  EXPECT_EQ(UtcText(Since("1969-12-31T23:59:58.750Z")), "1969-12-31T23:59:58.750Z");
}

}  // namespace musher::cli::wall_time_test
