// A disk that is full, read-only or broken: it is reported once, and the robot continues.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sqlite3.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>

#include "musher/test/controller/journal_fixture.hpp"
#include "musher/test/support/wait.hpp"

namespace musher::journal_trouble_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

// During its lifetime no file of this process can grow beyond a few pages: writing fails as on a
// full disk.
class FullDisk {
 public:
  FullDisk() : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit full{16 << 10, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &full);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit before_{};
};

class JournalTrouble : public JournalTest {
 protected:
  void Damage(std::streamoff from) const {
    const auto size = static_cast<std::streamoff>(fs::file_size(path_));
    ASSERT_GT(size, from);
    std::fstream file(path_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(from);
    file << std::string(static_cast<std::size_t>(size - from), '\xa5');
  }
};

TEST_F(JournalTrouble, IsLoggedOnceAndWhatWaitedIsWrittenWhenItIsOver) {
  BlockThePath();
  Journal journal(path_, Options());
  for (std::int64_t time = 1; time <= 3; ++time) {
    journal.Append(Entry(time));
    EXPECT_FALSE(journal.Flush(kFlushTimeout));
  }
  EXPECT_THAT(Troubles(), ElementsAre(HasSubstr("unable to open database file")));
  ClearThePath();
  EXPECT_TRUE(journal.Flush(kFlushTimeout));
  EXPECT_THAT(Times(Read()), ElementsAre(1, 2, 3));
}

TEST_F(JournalTrouble, IsLoggedAgainWhenItComesBack) {
  BlockThePath();
  for (int spell = 1; spell <= 2; ++spell) {
    Journal journal(path_, Options());
    journal.Append(Entry(1));
    EXPECT_FALSE(journal.Flush(kFlushTimeout));
    EXPECT_THAT(Troubles(), SizeIs(spell));
  }
}

TEST_F(JournalTrouble, DropsTheOldestWaitingEntriesAndReportsHowMany) {
  BlockThePath();
  auto options = Options();
  options.max_waiting = 10;
  Journal journal(path_, options);
  for (std::int64_t time = 1; time <= 35; ++time) journal.Append(Entry(time));
  EXPECT_FALSE(journal.Flush(kFlushTimeout));
  ClearThePath();
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  const auto entries = Read();
  ASSERT_THAT(entries, SizeIs(11));
  EXPECT_EQ(entries[0].kind, "journal");
  EXPECT_EQ(entries[0].data, R"({"lost":25})");
  EXPECT_EQ(entries[1].wall_ns, 26);
  EXPECT_EQ(entries[10].wall_ns, 35);
}

TEST_F(JournalTrouble, IsRetriedByItself) {
  BlockThePath();
  std::promise<void> in_trouble;
  JournalOptions options;
  options.retry_period = Milliseconds(1);
  options.on_writing = [&](const Result<>& written) {
    if (!written) in_trouble.set_value();
  };
  Journal journal(path_, options);
  journal.Append(Entry(1));
  ASSERT_EQ(in_trouble.get_future().wait_for(kFlushTimeout), std::future_status::ready);
  ClearThePath();
  testing::Until([&] {
    const auto entries = ReadJournal(path_, 0, kAll);
    return entries && !entries.value().entries.empty();
  });
  EXPECT_THAT(Times(Read()), ElementsAre(1));
}

TEST_F(JournalTrouble, OfAFullDiskKeepsWhatWasWrittenAndContinuesWhenThereIsRoom) {
  Journal journal(path_, Options());
  journal.Append(Entry(1));
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  {
    const FullDisk full;
    for (std::int64_t time = 2; time <= 60; ++time) {
      journal.Append(Entry(time, std::string(1024, 'x')));
    }
    EXPECT_FALSE(journal.Flush(kFlushTimeout));
  }
  EXPECT_THAT(Troubles(), SizeIs(1));
  EXPECT_TRUE(journal.Flush(kFlushTimeout));
  const auto times = Times(Read());
  ASSERT_THAT(times, SizeIs(60));
  EXPECT_EQ(times.front(), 1);
  EXPECT_EQ(times.back(), 60);
}

TEST_F(JournalTrouble, DoesNotKeepAJournalFromClosing) {
  BlockThePath();
  { Journal(path_, Options()).Append(Entry(1)); }
  EXPECT_THAT(Troubles(), SizeIs(1));
}

TEST_F(JournalTrouble, OfAFileThatIsNoDatabaseMovesItAside) {
  std::ofstream(path_) << "Dear diary, today the dog ran away. " << std::string(4096, '.');
  { Journal(path_, Options()).Append(Entry(1)); }
  EXPECT_THAT(Troubles(), ElementsAre(HasSubstr(path_ + ".damaged-1")));
  EXPECT_EQ(fs::file_size(path_ + ".damaged-1"), 4132U);
  EXPECT_THAT(Times(Read()), ElementsAre(1));
}

TEST_F(JournalTrouble, OfADamagedHeaderMovesTheFileAsideAndLosesNoNewEntry) {
  { Journal(path_, Options()).Append(Entry(1)); }
  Damage(0);
  { Journal(path_, Options()).Append(Entry(2)); }
  EXPECT_THAT(Troubles(), ElementsAre(HasSubstr("damaged-1")));
  EXPECT_THAT(Times(Read()), ElementsAre(2));
}

TEST_F(JournalTrouble, OfDamagedPagesIsNoticedWhenTheyAreWrittenTo) {
  { Journal(path_, Options()).Append(Entry(1)); }
  Damage(4096);
  { Journal(path_, Options()).Append(Entry(2)); }
  EXPECT_THAT(Troubles(), ElementsAre(HasSubstr("malformed")));
  EXPECT_THAT(Times(Read()), ElementsAre(2));
}

TEST_F(JournalTrouble, NumbersTheFilesItMovesAside) {
  for (int n = 1; n <= 3; ++n) {
    std::ofstream(path_) << std::string(4096, '?');
    for (const char* companion : {"-wal", "-shm"}) fs::remove(path_ + companion);
    { Journal(path_, Options()).Append(Entry(n)); }
    EXPECT_TRUE(fs::exists(path_ + ".damaged-" + std::to_string(n)));
  }
}

TEST_F(JournalTrouble, OfAnotherProgramsDatabaseLeavesItAsItWas) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path_.c_str(), &database), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(database, "CREATE TABLE song (title)", nullptr, nullptr, nullptr),
            SQLITE_OK);
  sqlite3_close(database);
  const auto read = [](const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string before = read(path_);
  { Journal(path_, Options()).Append(Entry(1)); }
  EXPECT_THAT(Troubles(), ElementsAre(HasSubstr("it is not a journal")));
  EXPECT_EQ(read(path_ + ".damaged-1"), before);
  EXPECT_THAT(Times(Read()), ElementsAre(1));
}

TEST_F(JournalTrouble, OfANewerLayoutMovesTheFileAside) {
  { Journal(path_, Options()).Append(Entry(1)); }
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path_.c_str(), &database), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(database, "PRAGMA user_version = 99", nullptr, nullptr, nullptr),
            SQLITE_OK);
  sqlite3_close(database);
  { Journal(path_, Options()).Append(Entry(2)); }
  EXPECT_THAT(Troubles(), ElementsAre(HasSubstr("its version is 99, not 3")));
  EXPECT_THAT(Times(Read()), ElementsAre(2));
}

}  // namespace musher::journal_trouble_test
