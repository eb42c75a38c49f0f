// A journal that is read again and again: each entry once, in the journal's order.

#include "musher/wire/journal_cursor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace musher::journal_cursor_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::uint32_t kMost = 1000;

class Journal {
 public:
  void Append(std::uint64_t id, std::int64_t wall_ns) {
    msg::HistoryEntry entry;
    entry.id = id;
    entry.wall_ns = wall_ns;
    entries_.push_back(entry);
  }
  // The newest so many but for the last `lacking`, which no disk has yet.
  msg::GetHistory::Response Newest(std::uint32_t limit, std::size_t lacking = 0) const {
    msg::GetHistory::Response answer;
    const std::size_t end = entries_.size() - lacking;
    for (std::size_t i = end - std::min<std::size_t>(end, limit); i < end; ++i) {
      answer.entries.push_back(entries_[i]);
      answer.events.push_back("event_" + std::to_string(entries_[i].id));
    }
    return answer;
  }

 private:
  std::vector<msg::HistoryEntry> entries_;
};

// The ids of what is new.
std::vector<std::uint64_t> Take(JournalCursor& cursor, const Journal& journal,
                                std::size_t lacking = 0) {
  auto fresh = cursor.Take(journal.Newest(cursor.limit(), lacking));
  while (!fresh) fresh = cursor.Take(journal.Newest(cursor.limit(), lacking));
  std::vector<std::uint64_t> ids;
  for (const msg::HistoryEntry& entry : fresh.value().entries) ids.push_back(entry.id);
  EXPECT_THAT(fresh.value().events, SizeIs(ids.size()));
  return ids;
}

TEST(JournalCursor, TakesEachEntryOnceAlsoThoseOfTheSameNanosecond) {
  Journal journal;
  JournalCursor cursor(100, kMost);
  for (const std::int64_t wall_ns : {50, 100, 105, 110}) journal.Append(wall_ns, wall_ns);
  EXPECT_THAT(Take(cursor, journal), ElementsAre(105, 110));
  EXPECT_THAT(Take(cursor, journal), IsEmpty());
  journal.Append(111, 110);
  journal.Append(120, 120);
  EXPECT_THAT(Take(cursor, journal), ElementsAre(111, 120));
}

// It took nothing until the clock had caught up: hours, for a robot that got its time late.
TEST(JournalCursor, GoesOnWhenTheWallClockIsSetBack) {
  Journal journal;
  JournalCursor cursor(0, kMost);
  journal.Append(1, 1000);
  EXPECT_THAT(Take(cursor, journal), ElementsAre(1));
  journal.Append(2, 10);
  journal.Append(3, 11);
  EXPECT_THAT(Take(cursor, journal), ElementsAre(2, 3));
  EXPECT_THAT(Take(cursor, journal), IsEmpty());
}

TEST(JournalCursor, TakesWhatIsAppendedToAnEmptyJournalAtAnyTime) {
  Journal journal;
  JournalCursor cursor(100, kMost);
  EXPECT_THAT(Take(cursor, journal), IsEmpty());
  journal.Append(1, 10);
  EXPECT_THAT(Take(cursor, journal), ElementsAre(1));
}

TEST(JournalCursor, AsksForMoreOnceManyWereAppended) {
  Journal journal;
  JournalCursor cursor(0, kMost);
  journal.Append(1, 1);
  EXPECT_THAT(Take(cursor, journal), SizeIs(1));
  for (std::uint64_t id = 2; id < 2 + 3 * JournalCursor::kFewEntries; ++id) journal.Append(id, 7);
  EXPECT_FALSE(cursor.Take(journal.Newest(cursor.limit())));
  EXPECT_EQ(cursor.limit(), 10 * JournalCursor::kNextEntries);
  EXPECT_FALSE(cursor.Take(journal.Newest(cursor.limit())));
  EXPECT_EQ(cursor.limit(), kMost);
  EXPECT_THAT(Take(cursor, journal), SizeIs(3 * JournalCursor::kFewEntries));
  EXPECT_EQ(cursor.limit(), JournalCursor::kNextEntries);
}

// An idle `history -f` asked for 200 entries three times a second, over a robot's radio link.
TEST(JournalCursor, AsksForFewEntriesWhileNothingIsNew) {
  Journal journal;
  JournalCursor cursor(0, kMost);
  for (std::uint64_t id = 1; id <= 500; ++id) journal.Append(id, 7);
  EXPECT_THAT(Take(cursor, journal), SizeIs(500));
  EXPECT_THAT(Take(cursor, journal), IsEmpty());
  EXPECT_LE(cursor.limit(), 20u);
  for (std::uint64_t id = 501; id <= 650; ++id) journal.Append(id, 7);
  EXPECT_THAT(Take(cursor, journal), SizeIs(150));
}

// The history is read again and again, and each time the newest entries of it.
RC_GTEST_PROP(JournalCursorProperty, HoweverOftenAJournalIsReadEachEntryIsTakenOnce, ()) {
  Journal journal;
  JournalCursor cursor(-1, kMost);
  std::vector<std::uint64_t> expected, taken;
  const auto reads = *rc::gen::inRange(1, 12);
  for (int read = 0; read < reads; ++read) {
    const auto appended = *rc::gen::inRange(0, 300);
    for (int i = 0; i < appended; ++i) {
      expected.push_back(expected.size() + 1);
      journal.Append(expected.back(), *rc::gen::inRange(0, 50));  // the wall clock may be set
    }
    for (const std::uint64_t id : Take(cursor, journal)) taken.push_back(id);
  }
  RC_ASSERT(taken == expected);
}

TEST(JournalCursor, OfMoreThanTheMostTakesTheNewest) {
  Journal journal;
  JournalCursor cursor(0, 300);
  for (std::uint64_t id = 1; id <= 1000; ++id) journal.Append(id, 7);
  const auto ids = Take(cursor, journal);
  EXPECT_THAT(ids, SizeIs(300));
  EXPECT_EQ(ids.front(), 701u);
}

TEST(JournalCursor, KnowsALongJournalFromBeforeItsBegin) {
  Journal journal;
  JournalCursor nothing(INT64_MAX, kMost);
  for (std::uint64_t id = 1; id <= 1000; ++id) journal.Append(id, 7);
  EXPECT_THAT(Take(nothing, journal), IsEmpty());
  EXPECT_EQ(nothing.limit(), JournalCursor::kNextEntries);
  journal.Append(1001, 3);
  EXPECT_THAT(Take(nothing, journal), ElementsAre(1001));
}

// An answer with fewer entries than the one before reaches further back; so may one with more.
TEST(JournalCursor, RepeatsNothingWhenAnAnswerLacksTheNewestEntries) {
  Journal journal;
  JournalCursor cursor(INT64_MAX, kMost);
  for (std::uint64_t id = 1; id <= 500; ++id) journal.Append(id, 7);
  EXPECT_THAT(Take(cursor, journal), IsEmpty());
  journal.Append(501, 8);
  EXPECT_THAT(Take(cursor, journal), ElementsAre(501));
  EXPECT_THAT(Take(cursor, journal, 100), IsEmpty());
  EXPECT_THAT(Take(cursor, journal), IsEmpty());
}

// `history -f -n 2` printed the whole journal once a slow disk lacked these two.
TEST(JournalCursor, RepeatsNothingWhenAnAnswerLacksTheFewEntriesThatAReaderHasShown) {
  Journal journal;
  JournalCursor cursor(INT64_MAX, kMost);
  for (std::uint64_t id = 1; id <= 50; ++id) journal.Append(id, 7);
  EXPECT_THAT(cursor.Take(journal.Newest(JournalCursor::FirstLimit(2)))->entries, IsEmpty());
  journal.Append(51, 8);
  EXPECT_THAT(Take(cursor, journal, 3), IsEmpty());
  EXPECT_THAT(Take(cursor, journal), ElementsAre(51));
}

TEST(JournalCursor, AJournalThatIsBegunAgainIsAllNew) {
  Journal journal;
  JournalCursor cursor(0, kMost);
  journal.Append(1, 100);
  EXPECT_THAT(Take(cursor, journal), ElementsAre(1));
  Journal next;
  next.Append(1, 90);
  next.Append(2, 91);
  EXPECT_THAT(Take(cursor, next), ElementsAre(1, 2));
}

// A reader that goes over to a machine of another host, or to another state folder: each old
// trouble of that one was new.
TEST(JournalCursor, OfAnotherLongJournalTakesWhatIsLaterThanAllThatItHad) {
  Journal journal;
  JournalCursor cursor(0, kMost);
  journal.Append(1, 1000);
  EXPECT_THAT(Take(cursor, journal), ElementsAre(1));
  Journal other;
  for (std::uint64_t id = 1; id <= 300; ++id) other.Append(id + 7, 500);
  other.Append(2, 1001);
  EXPECT_THAT(Take(cursor, other), ElementsAre(2));
}

TEST(JournalCursor, TakesWhatIsOnADiskThatAnswersLater) {
  Journal disk;
  JournalCursor cursor(0, kMost);
  disk.Append(1, 10);
  disk.Append(2, 20);
  disk.Append(3, 30);
  auto unwritten = disk.Newest(1);
  unwritten.error = "the disk does not answer";
  EXPECT_THAT(cursor.Take(unwritten)->entries, SizeIs(1));
  EXPECT_THAT(Take(cursor, disk), ElementsAre(1, 2));
}

// The first answers were those of a disk that hung, with what it had not written alone.
TEST(JournalCursor, TakesWhatIsOnADiskThatAnswersLaterAlsoIfThatIsMuch) {
  Journal disk;
  JournalCursor cursor(0, kMost);
  for (std::uint64_t id = 1; id <= 50; ++id) disk.Append(id, 7);
  auto unwritten = disk.Newest(1);
  unwritten.error = "the disk does not answer";
  EXPECT_THAT(cursor.Take(unwritten)->entries, SizeIs(1));
  EXPECT_THAT(Take(cursor, disk), SizeIs(49)) << "all but the one that it had";
}

TEST(JournalCursor, AJournalThatCannotBeReadIsNotAnEmptyOne) {
  JournalCursor cursor(100, kMost);
  EXPECT_THAT(cursor.Take({"the disk is full", {}})->entries, IsEmpty());
  Journal journal;
  journal.Append(1, 10);
  journal.Append(2, 110);
  EXPECT_THAT(Take(cursor, journal), ElementsAre(2));
}

}  // namespace musher::journal_cursor_test
