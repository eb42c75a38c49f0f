#include "musher/view/record/ring.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace musher::view::ring_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::int64_t kSecond = 1'000'000'000;

// Of the steady clock.
Time At(int s) {
  return Time(std::chrono::seconds(s));
}

RingOptions Minute() {
  return {std::chrono::seconds(60), std::chrono::seconds(30), std::chrono::seconds(10), 3};
}

// The segments on disk after the actions, and what was kept.
struct Disk {
  void Do(const std::vector<RingAction>& actions) {
    for (const RingAction& action : actions) {
      if (const auto* begin = std::get_if<BeginSegment>(&action)) segments.insert(begin->number);
      if (const auto* old = std::get_if<DeleteSegment>(&action)) segments.erase(old->number);
      if (const auto* keep = std::get_if<KeepSegments>(&action)) {
        for (const std::uint64_t number : keep->numbers) EXPECT_TRUE(segments.contains(number));
        kept.push_back(*keep);
      }
    }
  }
  void Run(Ring& ring, int from_s, int to_s) {
    for (int s = from_s; s < to_s; ++s) Do(ring.At(At(s)));
  }

  std::set<std::uint64_t> segments;
  std::vector<KeepSegments> kept;
};

TEST(Ring, WithoutTroubleOnlyTheLastMinuteIsOnDisk) {
  Ring ring(Minute());
  Disk disk;
  disk.Run(ring, 0, 1000);
  EXPECT_THAT(disk.segments, ElementsAre(94, 95, 96, 97, 98, 99, 100));
  EXPECT_THAT(disk.kept, IsEmpty());
  EXPECT_THAT(ring.End(At(1000)), IsEmpty());
}

TEST(Ring, AfterTroubleTheMinuteBeforeAndHalfAMinuteAfterAreKept) {
  Ring ring(Minute());
  Disk disk;
  disk.Run(ring, 0, 505);
  ring.OnTrouble("emergency-stop", At(505), 505 * kSecond);
  disk.Run(ring, 505, 535);
  EXPECT_THAT(disk.kept, IsEmpty());
  disk.Run(ring, 535, 600);
  ASSERT_EQ(disk.kept.size(), 1U);
  EXPECT_EQ(disk.kept[0].reason, "emergency-stop");
  EXPECT_EQ(disk.kept[0].trouble_ns, 505 * kSecond);
  // From second 440 (segment 45 begins there) to 535.
  EXPECT_EQ(disk.kept[0].numbers.front(), 45U);
  EXPECT_EQ(disk.kept[0].numbers.back(), 54U);
  EXPECT_LE(disk.segments.size(), 8U);
}

TEST(Ring, MoreTroubleMeanwhileIsInTheSameFile) {
  Ring ring(Minute());
  Disk disk;
  disk.Run(ring, 0, 100);
  ring.OnTrouble("audio-crashed", At(100), 100 * kSecond);
  disk.Run(ring, 100, 120);
  ring.OnTrouble("emergency-stop", At(120), 120 * kSecond);
  disk.Run(ring, 120, 150);
  EXPECT_THAT(disk.kept, IsEmpty());
  disk.Run(ring, 150, 151);
  ASSERT_EQ(disk.kept.size(), 1U);
  EXPECT_EQ(disk.kept[0].reason, "audio-crashed");
}

TEST(Ring, TroubleWithoutAnEndFillsNoDisk) {
  Ring ring(Minute());
  Disk disk;
  for (int s = 0; s < 1000; ++s) {
    ring.OnTrouble("audio-crashed", At(s), s * kSecond);
    disk.Do(ring.At(At(s)));
    EXPECT_LE(disk.segments.size(), 16U);
  }
  EXPECT_GT(disk.kept.size(), 10U);
}

TEST(Ring, TroubleJustBeforeTheEndIsKeptAtTheEnd) {
  Ring ring(Minute());
  Disk disk;
  disk.Run(ring, 0, 25);
  ring.OnTrouble("error", At(24), 24 * kSecond);
  disk.Do(ring.End(At(25)));
  ASSERT_EQ(disk.kept.size(), 1U);
  EXPECT_THAT(disk.kept[0].numbers, ElementsAre(1, 2, 3));
}

TEST(Ring, NamesAKeptFileByItsTimeAndReason) {
  EXPECT_EQ(KeptName(1'772'366'405 * kSecond, "emergency-stop"),
            "2026-03-01T12-00-05Z_emergency-stop.mcap");
  EXPECT_EQ(KeptName(0, "../x y"), "1970-01-01T00-00-00Z_---x-y.mcap");
}

TEST(Ring, KnowsItsFilesByTheirNames) {
  EXPECT_TRUE(IsKeptName(KeptName(1'772'366'405 * kSecond, "error")));
  for (const char* other : {"run.mcap", "2026-03-01.mcap", "2026-03-01T12-00-05Z_error.mcap.gz",
                            "musher_2026-03-01_12-00-05.mcap", ""}) {
    EXPECT_FALSE(IsKeptName(other)) << other;
  }
  EXPECT_EQ(SegmentNumber(SegmentName(12)), 12U);
  EXPECT_EQ(SegmentNumber(SegmentName(123'456'789)), 123'456'789U);
  for (const char* other : {"12.mcap", "00000000.mcap", "00000012.mcap.bak", "song.mcap", ""}) {
    EXPECT_EQ(SegmentNumber(other), 0U) << other;
  }
}

TEST(Ring, TheOldestKeptFilesMakeRoom) {
  EXPECT_THAT(OldestBeyond({"c", "a", "b"}, 2), ElementsAre("a"));
  EXPECT_THAT(OldestBeyond({"a"}, 2), IsEmpty());
}

}  // namespace musher::view::ring_test
