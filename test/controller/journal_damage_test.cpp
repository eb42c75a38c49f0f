// A journal that is cut short or has wrong bytes is read as far as possible: whatever is not read
// is reported as missing.

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "musher/controller/journal/replay.hpp"
#include "musher/test/controller/journal_fixture.hpp"
#include "musher/test/controller/recorded_robot.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::journal_damage_test {

namespace fs = std::filesystem;

class JournalDamage : public JournalTest {
 protected:
  // A journal of several pages for each table, closed: one file.
  JournalDamage() {
    {
      Journal journal(path_, Options());
      const auto life = RecordedLife();
      for (int i = 0; i < 3; ++i) {
        for (const JournalItem& item : life) journal.Append(item);
      }
    }
    std::ifstream file(path_, std::ios::binary);
    whole_.assign(std::istreambuf_iterator<char>(file), {});
    entries_ = ReadJournal(path_, 0, kAll).value().entries;
    rows_ = ReadRecording(path_).value().rows;
  }

  void Put(const std::string& bytes) const {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes;
  }

  // Reads the remaining entries in both directions.
  void ExpectReportedOrMissing(const std::string& what) {
    const auto history = ReadJournal(path_, 0, kAll);
    if (history) {
      ++read_;
      const auto& entries = history.value().entries;
      if (!history.value().damage.empty()) ++said_;
      EXPECT_TRUE(entries.size() == entries_.size() || !history.value().damage.empty()) << what;
      EXPECT_LE(entries.size(), entries_.size()) << what;
      ExpectPartOf(entries, what);
    } else {
      EXPECT_THAT(history.error().message, ::testing::HasSubstr(path_)) << what;
    }
    const auto recording = ReadRecording(path_);
    if (!recording) return;
    const auto& rows = recording.value().rows;
    EXPECT_TRUE(rows.size() == rows_.size() || !recording.value().damage.empty()) << what;
    const auto report = recording::Replay(rows, {});
    if (report) {
      EXPECT_EQ(report.value().differences, 0U) << what;
    }
  }

  void ExpectPartOf(const std::vector<JournalEntry>& entries, const std::string& what) const {
    auto from = entries_.begin();
    for (const JournalEntry& entry : entries) {
      from = std::find(from, entries_.end(), entry);
      ASSERT_NE(from, entries_.end()) << what;
      ++from;
    }
  }

  std::string whole_;
  std::vector<JournalEntry> entries_;
  std::vector<JournalRow> rows_;
  int read_ = 0;  // how often something could be read
  int said_ = 0;  // how often that something was missing
};

TEST_F(JournalDamage, CutShortAnywhereIsReadAsFarAsItGoes) {
  ASSERT_GT(whole_.size(), 100'000U);
  for (std::size_t size = 0; size < whole_.size(); size += testing::Nightly() ? 1531 : 6133) {
    Put(whole_.substr(0, size));
    ExpectReportedOrMissing("cut to " + std::to_string(size));
  }
  EXPECT_GT(read_, 5);
  EXPECT_GT(said_, 5);
}

TEST_F(JournalDamage, WithAPageOfGarbageIsReadFromBothEnds) {
  constexpr std::size_t kPage = 4096;
  std::size_t most = 0;
  for (std::size_t page = 1; page < whole_.size() / kPage; page += testing::Nightly() ? 1 : 3) {
    std::string bytes = whole_;
    for (std::size_t i = 0; i < kPage; ++i)
      bytes[page * kPage + i] = static_cast<char>(i * 37 + page);
    Put(bytes);
    ExpectReportedOrMissing("page " + std::to_string(page));
    const auto history = ReadJournal(path_, 0, kAll);
    if (!history || history.value().damage.empty()) continue;
    most = std::max(most, history.value().entries.size());
    EXPECT_THAT(history.value().damage,
                ::testing::HasSubstr("read " + std::to_string(history.value().entries.size()) +
                                     " entries; the rest is damaged: "));
  }
  EXPECT_GT(said_, 5);
  EXPECT_GT(most, entries_.size() / 2);
}

TEST_F(JournalDamage, WithFlippedBytesIsReadWithoutACrash) {
  const std::size_t step = testing::Nightly() ? 397 : 4813;
  for (std::size_t at = 16; at < whole_.size(); at += step) {
    std::string bytes = whole_;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
    Put(bytes);
    ExpectReportedOrMissing("flipped " + std::to_string(at));
  }
  EXPECT_GT(read_, 25);
  EXPECT_GT(said_, 0);
}

TEST_F(JournalDamage, InAnInputIsNoticedByItsChecksum) {
  std::string bytes = whole_;
  const auto at = bytes.find(R"({"event":"StatusSeen")");
  ASSERT_NE(at, std::string::npos);
  bytes[at + 12] = 'X';
  Put(bytes);
  const auto recording = ReadRecording(path_);
  ASSERT_TRUE(recording);
  EXPECT_EQ(recording.value().rows.size(), rows_.size() - 1);
  EXPECT_THAT(recording.value().damage, ::testing::HasSubstr(": wrong checksum or missing data"));
  const auto report = recording::Replay(recording.value().rows, {});
  ASSERT_TRUE(report);
  EXPECT_EQ(report.value().differences, 0U) << "nothing is made up for what is missing";
  EXPECT_THAT(
      report.value().notes,
      ::testing::ElementsAre(::testing::ContainsRegex("number [0-9]+ of the journal is missing")));
}

// SQLite reads the missing end of a page as zeros, and a row of zeros has no checksum.
TEST_F(JournalDamage, ThatClearsAChecksumIsNoticed) {
  SQLite::Database(path_, SQLite::OPEN_READWRITE)
      .exec("UPDATE entry SET checksum = 0 WHERE id = (SELECT id FROM entry LIMIT 1 OFFSET 4)");
  const auto history = ReadJournal(path_, 0, kAll);
  ASSERT_TRUE(history);
  EXPECT_EQ(history.value().entries.size(), entries_.size() - 1);
  EXPECT_THAT(history.value().damage, ::testing::HasSubstr(": wrong checksum or missing data"));
  EXPECT_EQ(ReadRecording(path_).value().rows.size(), rows_.size() - 1);
}

TEST_F(JournalDamage, WhatIsNoJournalIsRefused) {
  std::string other_database = whole_;
  other_database[68] = 'X';  // of the number that identifies a journal among databases
  for (const std::string& bytes : {std::string(), std::string("Dear diary"), other_database}) {
    Put(bytes);
    EXPECT_FALSE(ReadJournal(path_, 0, kAll));
    EXPECT_FALSE(ReadRecording(path_));
  }
}

// What kill -9 in the middle of a write leaves: all in the WAL, cut anywhere.
TEST_F(JournalDamage, InHalfAWalIsReadUpToTheLastTransactionThatIsWhole) {
  const std::string copy = folder_ / "copy.sqlite";
  {
    fs::remove(path_);
    Journal journal(path_, Options());
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      journal.Append(rows_[i].item);
      if (i % 200 == 0) {
        ASSERT_TRUE(journal.Flush(kFlushTimeout));
      }
    }
    ASSERT_TRUE(journal.Flush(kFlushTimeout));
    fs::copy_file(path_, copy);
    fs::copy_file(path_ + "-wal", copy + "-wal");
  }
  const auto size = fs::file_size(copy + "-wal");
  std::size_t before = 0;
  for (std::uintmax_t cut = 0; cut <= size; cut += size / (testing::Nightly() ? 50 : 12)) {
    const std::string half = folder_ / "half.sqlite";
    for (const char* end : {"", "-wal"}) {
      fs::copy_file(copy + end, half + end, fs::copy_options::overwrite_existing);
    }
    fs::remove(half + "-shm");
    fs::resize_file(half + "-wal", cut);
    const auto recording = ReadRecording(half);
    if (!recording) continue;  // not even the tables are there
    const auto& rows = recording.value().rows;
    EXPECT_GE(rows.size(), before);
    before = rows.size();
    for (std::size_t i = 0; i < rows.size(); ++i) ASSERT_EQ(rows[i].id, rows_[i].id);
    if (rows.size() < 2) continue;  // a config alone can't be replayed
    const auto report = recording::Replay(rows, {});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report.value().differences, 0U) << cut << " of " << size;
  }
  EXPECT_GT(before, rows_.size() / 2);
}

}  // namespace musher::journal_damage_test
