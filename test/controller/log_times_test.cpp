// Marks on disk, and what a rotation makes of them.

#include "musher/controller/storage/log_times.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "musher/test/support/temp_folder.hpp"

namespace musher::log_times_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class Marks : public ::testing::Test {
 protected:
  std::int64_t At(std::int64_t end, std::int64_t live_bytes, std::uint64_t part = kLiveLog) const {
    return LogTimes(log_, live_bytes).At(part, end);
  }

  const TempFolder folder_;
  const std::string log_ = folder_ / "legs.log";
};

TEST_F(Marks, TellWhenALineWasWritten) {
  LogMarker marker(log_);
  ASSERT_TRUE(marker.Mark(0, 100));
  ASSERT_TRUE(marker.Mark(10, 200));
  ASSERT_TRUE(marker.Mark(10, 300)) << "nothing was written meanwhile";
  ASSERT_TRUE(marker.Mark(30, 400));
  EXPECT_EQ(At(5, 30), 200);
  EXPECT_EQ(At(10, 30), 200);
  EXPECT_EQ(At(11, 30), 400);
  EXPECT_EQ(At(31, 40), 0) << "not marked yet";
}

TEST_F(Marks, DoNotTellWhenALineWasWrittenWhileNothingWasMarked) {
  ASSERT_TRUE(LogMarker(log_).Mark(0, 100));
  LogMarker later(log_);
  ASSERT_TRUE(later.Mark(20, 900));
  ASSERT_TRUE(later.Mark(30, 1000));
  EXPECT_EQ(At(20, 30), 0);
  EXPECT_EQ(At(30, 30), 1000);
}

TEST_F(Marks, GoOnWhereAnEarlierControllerEnded) {
  {
    LogMarker earlier(log_);
    ASSERT_TRUE(earlier.Mark(0, 100));
    ASSERT_TRUE(earlier.Mark(20, 200));
  }
  LogMarker later(log_);
  ASSERT_TRUE(later.Mark(20, 900));
  ASSERT_TRUE(later.Mark(30, 1000));
  EXPECT_EQ(At(20, 30), 200);
  EXPECT_EQ(At(30, 30), 1000);
}

TEST_F(Marks, OfAFileThatBeganAgainAreNotThoseOfTheOldOne) {
  LogMarker marker(log_);
  ASSERT_TRUE(marker.Mark(0, 100));
  ASSERT_TRUE(marker.Mark(50, 200));
  ASSERT_TRUE(marker.Mark(20, 300)) << "shorter than before";
  EXPECT_EQ(At(20, 20), 300);
  ASSERT_TRUE(marker.Begin());
  ASSERT_TRUE(marker.Mark(60, 400));
  EXPECT_EQ(At(20, 60), 400);
}

TEST_F(Marks, FollowTheirBytesIntoAPart) {
  LogMarker marker(log_);
  ASSERT_TRUE(marker.Mark(0, 100));
  ASSERT_TRUE(marker.Mark(40, 200));
  ASSERT_TRUE(marker.Mark(100, 300));
  ASSERT_TRUE(marker.Cut(60, 10, 1, {1}));
  EXPECT_EQ(At(40, 30, 1), 200);
  EXPECT_EQ(At(60, 30, 1), 300) << "the mark behind its end";
  EXPECT_EQ(At(30, 30), 300);
  ASSERT_TRUE(marker.Mark(50, 400));
  ASSERT_TRUE(marker.Cut(50, 0, 2, {2})) << "part 1 is gone";
  EXPECT_EQ(At(40, 0, 1), 0);
  EXPECT_EQ(At(50, 0, 2), 400);
}

TEST(MarksAfter, ACutInTheMiddleOfABurstKeepsItsTimeOnBothSides) {
  EXPECT_THAT(MarksAfterCut({{kLiveLog, 100, 7}}, 60, 0, 3),
              ElementsAre(LogMark{3, 60, 7}, LogMark{kLiveLog, 40, 7}));
  EXPECT_THAT(MarksAfterCut({{kLiveLog, 100, 7}}, 0, 100, 3), IsEmpty()) << "all was dropped";
}

TEST(MarksAfter, TheNewestAreKeptAndWhatTheOthersCoveredIsNotKnown) {
  EXPECT_THAT(NewestMarks({{1, 10, 1}, {1, 20, 2}, {kLiveLog, 10, 3}}, 1),
              ElementsAre(LogMark{1, 20, 0}, LogMark{kLiveLog, 10, 3}));
  EXPECT_THAT(NewestMarks({{1, 10, 1}}, 1), ElementsAre(LogMark{1, 10, 1}));
}

}  // namespace musher::log_times_test
