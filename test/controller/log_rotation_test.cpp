#include "musher/controller/storage/log_rotation.hpp"

#include <gmock/gmock.h>

namespace musher::log_rotation_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

constexpr std::int64_t kMb = 1 << 20;

// Of 50 MB: 10 for the live file, 30 for the compressed parts.
LogSizes Log(std::int64_t live_bytes, std::vector<std::int64_t> parts = {}) {
  LogSizes log{50 * kMb, live_bytes, {}, false};
  for (const std::int64_t bytes : parts) {
    const auto number = log.parts.size() + 1;
    log.parts.push_back({number, bytes, static_cast<std::int64_t>(number) * 1000});
  }
  return log;
}

TEST(RotationOf, LeavesALogAloneThatIsSmallEnough) {
  EXPECT_EQ(RotationOf(Log(0)), LogActions{});
  EXPECT_EQ(RotationOf(Log(10 * kMb, {kMb, kMb})), LogActions{});
}

TEST(RotationOf, SavesALogThatIsTooLargeButForItsTail) {
  const LogActions actions = RotationOf(Log(10 * kMb + 1));
  EXPECT_EQ(actions.save, 10 * kMb + 1 - (64 << 10));
  EXPECT_EQ(actions.drop, 0);
  EXPECT_THAT(actions.remove, IsEmpty());
}

TEST(RotationOf, DropsTheMiddleOfAFlood) {
  const LogActions actions = RotationOf(Log(120 * kMb));
  EXPECT_EQ(actions.save, 20 * kMb) << "how it began";
  EXPECT_EQ(actions.save + actions.drop, 120 * kMb - (64 << 10)) << "in the next step";
}

TEST(RotationOf, RemovesTheOldestParts) {
  EXPECT_THAT(RotationOf(Log(0, {16 * kMb, 15 * kMb, 9 * kMb, 8 * kMb})).remove, ElementsAre(1, 2));
  EXPECT_THAT(RotationOf(Log(0, std::vector<std::int64_t>(23, 10))).remove, ElementsAre(1, 2, 3));
}

TEST(RotationOf, MakesRoomOnAFullDiskByTheOldestPart) {
  LogSizes log = Log(11 * kMb, {kMb, kMb});
  log.no_room = true;
  const LogActions actions = RotationOf(log);
  EXPECT_THAT(actions.remove, ElementsAre(1));
  EXPECT_GT(actions.save, 0) << "tried again with the room that was made";
}

TEST(RotationOf, DropsTheOldestOnAFullDiskWithoutParts) {
  LogSizes log = Log(11 * kMb);
  log.no_room = true;
  EXPECT_GT(RotationOf(log).save, 0) << "there may be room by now";
  EXPECT_EQ(RotationOf(log).drop, 0);
  log.live_bytes = 21 * kMb;
  EXPECT_EQ(RotationOf(log), (LogActions{0, 11 * kMb, {}}));
}

// Whatever is printed in a second, up to a fifth of the bound, and however badly it compresses.
TEST(RotationOf, KeepsALogBelowItsBound) {
  LogSizes log = Log(0);
  std::int64_t printed = 0;
  std::int64_t kept = 0;
  for (int second = 0; second < 1000; ++second) {
    log.live_bytes += (second * 7919 % 10 + 1) * kMb;
    printed = log.live_bytes;
    const LogActions actions = RotationOf(log);
    EXPECT_EQ(actions.drop, 0);
    for (const auto number : actions.remove) {
      EXPECT_EQ(log.parts.front().number, number);
      log.parts.erase(log.parts.begin());
    }
    if (actions.save > 0) {
      const std::uint64_t next = log.parts.empty() ? 1 : log.parts.back().number + 1;
      log.parts.push_back({next, actions.save, 0});
    }
    EXPECT_LE(log.total(), log.max_bytes) << "while the part is there and in the live file, too";
    log.live_bytes -= actions.save;
    kept += actions.save;
  }
  EXPECT_GT(kept, 0);
  EXPECT_GT(printed, 0);
}

TEST(PartsBeyond, TakesTheOldestOfAllLogsFirst) {
  LogSizes one = Log(10, {100, 100});
  LogSizes two = Log(10, {100, 100});
  two.parts[0].written_ns = 1500;
  two.parts[1].written_ns = 1600;
  EXPECT_THAT(PartsBeyond(420, {one, two}), IsEmpty());
  EXPECT_THAT(PartsBeyond(419, {one, two}), ElementsAre(Pair(0, 1)));
  EXPECT_THAT(PartsBeyond(220, {one, two}), ElementsAre(Pair(0, 1), Pair(1, 1)));
  EXPECT_THAT(PartsBeyond(0, {one, two}),
              ElementsAre(Pair(0, 1), Pair(1, 1), Pair(1, 2), Pair(0, 2)));
}

// Each new part went at once, until the clock was where it had been.
TEST(PartsBeyond, TakesTheOldestOfALogFirstAlsoWhereTheClockWasSetBack) {
  const LogSizes log{1000, 10, {{1, 100, 9000}, {2, 100, 9010}, {3, 100, 20}}};
  EXPECT_THAT(PartsBeyond(250, {log}), ElementsAre(Pair(0, 1)));
  const LogSizes other{1000, 10, {{1, 100, 10}, {2, 100, 30}}};
  EXPECT_THAT(PartsBeyond(250, {log, other}), ElementsAre(Pair(1, 1), Pair(0, 1), Pair(0, 2)));
}

TEST(LogBound, IsLessWhereThereAreManyLogs) {
  EXPECT_EQ(LogBound(50 * kMb, 500 * kMb, 0), 50 * kMb);
  EXPECT_EQ(LogBound(50 * kMb, 500 * kMb, 16), 50 * kMb);
  // Their live files, a fifth of that, may take half of the whole.
  EXPECT_EQ(LogBound(50 * kMb, 500 * kMb, 50), 25 * kMb);
}

}  // namespace musher::log_rotation_test
