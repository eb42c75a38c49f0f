// What a journal lacks while its disk fails, and how that is known: to a caller now, and to the
// next controller.

#include "musher/controller/journal/journal_gap.hpp"

#include <gmock/gmock.h>

#include "musher/controller/journal/history_reader.hpp"
#include "musher/test/controller/journal_fixture.hpp"

namespace musher::journal_gap_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class JournalGaps : public JournalTest {
 protected:
  // A controller that is killed while it cannot write: its queue is lost.
  void LeaveAGap() {
    BlockThePath();
    { Journal(path_, Options()).Append(Entry(1)); }
    ClearThePath();
  }
};

TEST_F(JournalGaps, AHistoryHasTheEntriesThatAreOnlyInMemoryAndSinceWhen) {
  BlockThePath();
  Journal journal(path_, Options());
  for (std::int64_t time = 1; time <= 3; ++time) journal.Append(Entry(time));
  ASSERT_FALSE(journal.Flush(kFlushTimeout));
  const auto history = WithUnwritten(ReadJournal(path_, 2, 10), journal.Unwritten(), 2, 10);
  ASSERT_TRUE(history) << history.error().message;
  EXPECT_THAT(Times(history.value().entries), ElementsAre(2, 3));
  EXPECT_THAT(history.value().damage, HasSubstr("the journal is not on disk since 2"));
  EXPECT_THAT(history.value().damage, HasSubstr("Z: unable to open database file; 3 entries"));
  EXPECT_THAT(history.value().damage, HasSubstr("can't read the journal"));
  const auto newest = WithUnwritten(ReadJournal(path_, 0, 1), journal.Unwritten(), 0, 1);
  EXPECT_THAT(Times(newest.value().entries), ElementsAre(3));
}

TEST_F(JournalGaps, AHistoryReportsThatAWriteIsSlow) {
  const auto history = WithUnwritten(JournalReading{{Entry(1)}, ""}, {}, 0, 10);
  EXPECT_THAT(Times(history.value().entries), ElementsAre(1));
  EXPECT_THAT(history.value().damage, HasSubstr("the newest entries may be missing"));
}

TEST_F(JournalGaps, WritingReportsThatItFailsAndThatItWorksAgain) {
  BlockThePath();
  std::mutex mutex;
  std::vector<bool> states;
  auto options = Options();
  options.on_writing = [&](const Result<>& written) {
    const std::lock_guard lock(mutex);
    states.push_back(written.ok());
  };
  Journal journal(path_, options);
  journal.Append(Entry(1));
  EXPECT_FALSE(journal.Flush(kFlushTimeout));
  ClearThePath();
  EXPECT_TRUE(journal.Flush(kFlushTimeout));
  journal.Append(Entry(2));
  EXPECT_TRUE(journal.Flush(kFlushTimeout));
  const std::lock_guard lock(mutex);
  EXPECT_THAT(states, ElementsAre(false, true));
}

TEST_F(JournalGaps, TheNextControllerRecordsWhatTheOneBeforeItCouldNotWrite) {
  LeaveAGap();
  const auto gap = ReadGap(path_);
  ASSERT_TRUE(gap);
  EXPECT_EQ(gap->why, "unable to open database file");
  { Journal(path_, Options()).Append(Entry(2)); }
  const auto entries = Read();
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_EQ(entries[0].kind, "journal");
  EXPECT_THAT(entries[0].message, HasSubstr("entries are missing before this one"));
  EXPECT_THAT(entries[0].message, HasSubstr(gap->Text()));
  EXPECT_EQ(entries[1].wall_ns, 2);
  EXPECT_EQ(ReadGap(path_), std::nullopt);
}

TEST_F(JournalGaps, AGapOfTwoControllersBeginsWithTheFirst) {
  LeaveAGap();
  const auto gap = ReadGap(path_);
  LeaveAGap();
  EXPECT_EQ(ReadGap(path_), gap);
}

TEST_F(JournalGaps, AJournalThatWasWrittenAfterAllHasNone) {
  BlockThePath();
  Journal journal(path_, Options());
  journal.Append(Entry(1));
  ASSERT_FALSE(journal.Flush(kFlushTimeout));
  EXPECT_TRUE(ReadGap(path_));
  ClearThePath();
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  EXPECT_EQ(ReadGap(path_), std::nullopt);
  EXPECT_THAT(Times(Read()), ElementsAre(1));
}

// A full disk has no room for a new file.
TEST_F(JournalGaps, TheRoomForTheNoteIsTakenWhileTheDiskWorks) {
  Journal journal(path_, Options());
  journal.Append(Entry(1));
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  EXPECT_EQ(std::filesystem::file_size(path_ + ".gap"), 512U);
}

}  // namespace musher::journal_gap_test
