// The journal keeps all that a replay needs, also when it loses its beginning, and brings older
// journals up to date.

#include <gmock/gmock.h>
#include <sqlite3.h>

#include "musher/controller/journal/replay.hpp"
#include "musher/test/controller/journal_fixture.hpp"
#include "musher/test/controller/recorded_robot.hpp"

namespace musher::journal_recording_test {

using recording::ReplayReport;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class JournalRecording : public JournalTest {
 protected:
  void Write(const std::vector<JournalItem>& items, const JournalOptions& options) {
    Journal journal(path_, options);
    std::size_t n = 0;
    for (const JournalItem& item : items) {
      journal.Append(item);
      if (++n % 100 == 0) {
        ASSERT_TRUE(journal.Flush(kFlushTimeout));
      }
    }
  }

  JournalRows ReadAll() const {
    auto recording = ReadRecording(path_);
    if (recording) return std::move(recording).value();
    ADD_FAILURE() << recording.error().message;
    return {};
  }

  static ReplayReport Replayed(const JournalRows& recording) {
    auto report = recording::Replay(recording.rows, {});
    if (report) return std::move(report).value();
    ADD_FAILURE() << report.error().message;
    return {};
  }

  void Execute(const char* sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(path_.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database);
    sqlite3_close(database);
  }
};

TEST_F(JournalRecording, GivesBackWhatWentIntoTheDecisionsInItsOrder) {
  const auto items = RecordedLife();
  Write(items, Options());
  const JournalRows recording = ReadAll();
  EXPECT_EQ(recording.damage, "");
  ASSERT_EQ(recording.rows.size(), items.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    ASSERT_EQ(recording.rows[i].id, static_cast<std::int64_t>(i) + 1);
    ASSERT_EQ(recording.rows[i].item.index(), items[i].index()) << i;
    if (const auto* entry = std::get_if<JournalEntry>(&items[i])) {
      ASSERT_EQ(std::get<JournalEntry>(recording.rows[i].item), *entry);
    }
  }
  const ReplayReport report = Replayed(recording);
  EXPECT_EQ(report.differences, 0U);
  EXPECT_EQ(report.starts, 2U);
  EXPECT_EQ(report.not_replayed, 0U);
  EXPECT_THAT(report.notes, IsEmpty());
  EXPECT_EQ(report.replayed_state, "Protected");
}

TEST_F(JournalRecording, CanStillBeReplayedWhenItHasLostItsBeginning) {
  auto items = RecordedLife();
  const auto life = items;
  while (items.size() < 6000) items.insert(items.end(), life.begin(), life.end());
  auto options = Options();
  options.max_bytes = 256 << 10;
  Write(items, options);
  const JournalRows recording = ReadAll();
  EXPECT_EQ(recording.damage, "");
  ASSERT_GT(recording.rows.size(), 100U);
  ASSERT_LT(recording.rows.size(), items.size() / 2);
  const ReplayReport report = Replayed(recording);
  EXPECT_EQ(report.differences, 0U);
  EXPECT_EQ(report.not_replayed, 0U) << "it begins with a snapshot";
  EXPECT_THAT(report.notes, IsEmpty());
  EXPECT_GT(report.inputs, 50U);
}

TEST_F(JournalRecording, RequestsASnapshotWhenNoneIsLeft) {
  auto options = Options();
  options.max_bytes = 256 << 10;
  Journal journal(path_, options);
  EXPECT_FALSE(journal.WantsSnapshot());
  for (std::int64_t time = 1; time <= 500; ++time) {
    journal.Append(Entry(time, std::string(1024, 'x')));
  }
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  EXPECT_TRUE(journal.WantsSnapshot());
  EXPECT_FALSE(journal.WantsSnapshot()) << "once is enough";
}

TEST_F(JournalRecording, ShowsTheGapWhereItemsWereLost) {
  auto options = Options();
  options.max_waiting = 10;
  options.retry_period = Milliseconds(3600000);
  std::filesystem::create_directory(path_);  // nothing can be written
  {
    Journal journal(path_, options);
    const auto items = RecordedLife();
    for (std::size_t i = 0; i < 40; ++i) journal.Append(items[i]);
    EXPECT_FALSE(journal.Flush(kFlushTimeout));
    std::filesystem::remove(path_);
    ASSERT_TRUE(journal.Flush(kFlushTimeout));
    EXPECT_TRUE(journal.WantsSnapshot());
  }
  const auto rows = ReadAll().rows;
  ASSERT_EQ(rows.size(), 11U);
  EXPECT_EQ(rows.front().id, 31) << "30 were lost";
  EXPECT_FALSE(recording::Replay(rows, {}).ok());
}

TEST_F(JournalRecording, OfAnotherVersionIsNotReadAndMovedAsideWithItsReason) {
  Write({Entry(1)}, Options());
  Execute("PRAGMA user_version = 5");
  EXPECT_THAT(ReadJournal(path_, 0, 1).error().message,
              HasSubstr("its version is 5, not 4: a newer Musher wrote it"));
  EXPECT_FALSE(ReadRecording(path_));

  Execute("PRAGMA user_version = 3");
  EXPECT_THAT(ReadRecording(path_).error().message,
              HasSubstr("its version is 3, not 4: an earlier Musher wrote it"));
  Write(RecordedLife(), Options());
  EXPECT_THAT(Troubles(), ElementsAre(HasSubstr("an earlier Musher wrote it")));
  EXPECT_EQ(Replayed(ReadAll()).differences, 0U);
  EXPECT_TRUE(std::filesystem::exists(path_ + ".damaged-1"));
}

}  // namespace musher::journal_recording_test
