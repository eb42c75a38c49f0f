// A disk that is full, read-only or broken: it is reported once, and the robot continues.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>

#include "musher/base/files.hpp"
#include "musher/controller/journal/history_reader.hpp"
#include "musher/test/controller/journal_fixture.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/linux_event_loop.hpp"

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

TEST_F(JournalTrouble, OfDamagedPagesThatAreWrittenToMovesTheFileAside) {
  { Journal(path_, Options()).Append(Entry(1)); }
  Damage(4096);
  { Journal(path_, Options()).Append(Entry(2)); }
  EXPECT_THAT(Troubles(), ElementsAre(HasSubstr("damaged-1")));
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
  EXPECT_THAT(Troubles(), ElementsAre(HasSubstr("its version is 99, not 4")));
  EXPECT_THAT(Times(Read()), ElementsAre(2));
}

// It was written into a file that no name led to any more.
TEST_F(JournalTrouble, OfARemovedFileBeginsAnotherAndRecordsIt) {
  Journal journal(path_, Options());
  journal.Append(Entry(1));
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  for (const char* file : {"", "-wal", "-shm"}) fs::remove(path_ + file);
  journal.Append(Entry(2));
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  EXPECT_THAT(Troubles(), ElementsAre(HasSubstr("was removed, or another volume was mounted")));
  EXPECT_TRUE(journal.WantsSnapshot());
  const auto entries = Read();
  ASSERT_THAT(entries, SizeIs(2));
  EXPECT_EQ(entries[0].kind, "journal");
  EXPECT_THAT(entries[0].message, HasSubstr("the journal's file was removed"));
  EXPECT_EQ(entries[1].wall_ns, 2);
}

TEST_F(JournalTrouble, OfARemovedFileIsNoticedWithoutAnEntry) {
  auto options = Options();
  options.look_period = Milliseconds(1);
  Journal journal(path_, options);
  journal.Append(Entry(1));
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  fs::remove(path_);    // and what stands beside it is left
  testing::Until([&] {  // while it is being made it is no journal yet
    const auto reading = ReadJournal(path_, 0, kAll);
    return reading && !reading.value().entries.empty();
  });
  journal.Append(Entry(2));
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  EXPECT_THAT(Read(), SizeIs(2));
}

TEST_F(JournalTrouble, OfAFolderThatIsReplacedLeavesTheJournalThere) {
  const std::string folder = folder_ / "volume";
  const std::string path = folder + "/journal.sqlite";
  { Journal(path, Options()).Append(Entry(1)); }
  fs::rename(folder, folder_ / "other");
  Journal journal(path, Options());
  journal.Append(Entry(2));
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  fs::rename(folder, folder_ / "before");
  fs::rename(folder_ / "other", folder);
  journal.Append(Entry(3));
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  const auto reading = ReadJournal(path, 0, kAll);
  ASSERT_TRUE(reading);
  ASSERT_THAT(reading.value().entries, SizeIs(3));
  EXPECT_EQ(reading.value().entries[0].wall_ns, 1);
  EXPECT_EQ(reading.value().entries[2].wall_ns, 3);
}

// With one wrong byte of the schema nothing was written any more.
TEST_F(JournalTrouble, OfOneWrongByteOfTheHeaderOrTheSchemaIsOver) {
  { Journal(path_, Options()).Append(Entry(1)); }
  const std::string whole = ReadFile(path_);
  ASSERT_GT(whole.size(), 4096U);
  for (std::size_t at = 0; at < 4096; at += at < 120 ? 1 : 13) {
    if (at > 120 && whole[at] == '\0') continue;  // not used
    for (const char* companion : {"-wal", "-shm"}) fs::remove(path_ + companion);
    std::string wrong = whole;
    wrong[at] = static_cast<char>(wrong[at] ^ 1);
    ASSERT_TRUE(WriteFile(path_, wrong));
    Journal journal(path_, Options());
    journal.Append(Entry(2));
    ASSERT_TRUE(journal.Flush(kFlushTimeout)) << "byte " << at << ": " << Troubles().back();
    const auto reading = ReadJournal(path_, 2, kAll);
    ASSERT_TRUE(reading) << "byte " << at << ": " << reading.error().message;
    ASSERT_THAT(reading.value().entries, SizeIs(1)) << "byte " << at;
  }
}

TEST_F(JournalTrouble, OfDamagedPagesIsNoticedAtTheStart) {
  {
    Journal journal(path_, Options());
    for (std::int64_t time = 1; time <= 500; ++time) {
      journal.Append(Entry(time, std::string(200, 'x')));
    }
  }
  const std::string whole = ReadFile(path_);
  const std::size_t middle = whole.size() / 2 / 4096 * 4096;
  ASSERT_TRUE(WriteFile(path_, std::string(whole).replace(middle, 4096, 4096, '\xa5')));
  { Journal(path_, Options()).Append(Entry(1000)); }
  EXPECT_THAT(Troubles(), ElementsAre(HasSubstr("quick_check: ")));
  EXPECT_THAT(Times(Read()), ElementsAre(1000));
}

// A file that the kernel does not open, as on a disk that does not answer: until it is released.
class Hanging {
 public:
  explicit Hanging(std::string path) : path_(std::move(path)) {
    EXPECT_EQ(mkfifo(path_.c_str(), 0600), 0);
  }
  Hanging(const Hanging&) = delete;
  Hanging& operator=(const Hanging&) = delete;
  // What waits in open() continues.
  ~Hanging() {
    const int file = open(path_.c_str(), O_RDWR | O_NONBLOCK);
    unlink(path_.c_str());
    close(file);
  }

 private:
  const std::string path_;
};

TEST_F(JournalTrouble, OfADiskThatDoesNotAnswerDoesNotHoldTheEnd) {
  const Hanging note(path_ + ".gap");
  auto options = Options();
  options.stop_timeout = Milliseconds(10);
  const auto begin = std::chrono::steady_clock::now();
  {
    Journal journal(path_, options);
    journal.Append(Entry(1));
    EXPECT_FALSE(journal.Flush(Milliseconds(10)));
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, kFlushTimeout);
}

TEST_F(JournalTrouble, OfADiskThatDoesNotAnswerDoesNotHoldTheEndOfAReader) {
  Journal journal(path_, Options());
  journal.Append(Entry(1));
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  fs::remove(path_);
  const Hanging file(path_);
  const auto begin = std::chrono::steady_clock::now();
  {
    transport::LinuxEventLoop loop;
    HistoryReader reader(loop, journal);
    reader.Read(0, kAll, [](const auto&) { ADD_FAILURE() << "it is over"; });
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, kFlushTimeout);
}

}  // namespace musher::journal_trouble_test
