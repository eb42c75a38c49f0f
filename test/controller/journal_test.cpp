#include "musher/controller/journal/journal.hpp"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <thread>

#include "musher/test/controller/journal_fixture.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::journal_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST_F(JournalTest, GivesBackEveryFieldOfAnEntry) {
  const JournalEntry entry{1700000000123456789,
                           42,
                           Epoch((std::uint64_t{1} << 63) + 5),
                           17,
                           "command",
                           "motion",
                           3009,
                           "a \"sentence\" — 'quoted'",
                           R"({"target":"Active"})",
                           RecordId((std::uint64_t{1} << 63) + 6),
                           8,
                           "Active",
                           "switch_done"};
  Journal journal(path_, Options());
  journal.Append(entry);
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  EXPECT_THAT(Read(), ElementsAre(entry));
  EXPECT_THAT(Troubles(), IsEmpty());
}

TEST_F(JournalTest, KeepsTheOrderOfAppendEvenWhenTheWallClockJumpsBack) {
  Journal journal(path_, Options());
  for (const std::int64_t time : {5, 6, 2, 3}) journal.Append(Entry(time));
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  EXPECT_THAT(Times(Read()), ElementsAre(5, 6, 2, 3));
}

TEST_F(JournalTest, ReadsTheNewestOldestFirst) {
  Journal journal(path_, Options());
  for (std::int64_t time = 1; time <= 100; ++time) journal.Append(Entry(time));
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  EXPECT_THAT(Times(Read(0, 3)), ElementsAre(98, 99, 100));
  EXPECT_THAT(Times(Read(99, 3)), ElementsAre(99, 100));
  EXPECT_THAT(Read(101), IsEmpty());
}

TEST_F(JournalTest, WritesWhatWaitsWhenItIsClosed) {
  {
    Journal journal(path_, Options());
    for (std::int64_t time = 1; time <= 1000; ++time) journal.Append(Entry(time));
  }
  EXPECT_EQ(Read().size(), 1000U);
}

TEST_F(JournalTest, ContinuesWhereTheLastControllerStopped) {
  { Journal(path_, Options()).Append(Entry(1)); }
  { Journal(path_, Options()).Append(Entry(2)); }
  EXPECT_THAT(Times(Read()), ElementsAre(1, 2));
  EXPECT_THAT(Troubles(), IsEmpty());
}

TEST_F(JournalTest, MakesItsFolder) {
  const std::string path = folder_ / "a/b/journal.sqlite";
  { Journal(path, Options()).Append(Entry(1)); }
  EXPECT_TRUE(ReadJournal(path, 0, 1));
}

TEST_F(JournalTest, IsReadableWhileItIsWrittenFromManyThreads) {
  Journal journal(path_, Options());
  journal.Append(Entry(1));
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  {
    const auto append = [&] {
      for (int i = 0; i < 500; ++i) journal.Append(Entry(2));
    };
    const std::array<std::jthread, 4> threads{std::jthread(append), std::jthread(append),
                                              std::jthread(append), std::jthread(append)};
    for (std::size_t seen = 0, i = 0; i < 20; ++i) {
      const auto now = Read().size();
      EXPECT_GE(now, seen);
      seen = now;
    }
  }
  ASSERT_TRUE(journal.Flush(kFlushTimeout));
  EXPECT_EQ(Read().size(), 2001U);
}

TEST_F(JournalTest, DropsItsOldestEntriesWhenItIsTooLarge) {
  {
    auto options = Options();
    options.max_bytes = 256 << 10;
    Journal journal(path_, options);
    const std::string kilobyte(1024, 'x');
    for (std::int64_t time = 1; time <= 2000; ++time) {
      journal.Append(Entry(time, kilobyte));
      if (time % 50 == 0) {
        ASSERT_TRUE(journal.Flush(kFlushTimeout));
      }
    }
  }
  const auto times = Times(Read());
  ASSERT_GT(times.size(), 100U) << "more was dropped than necessary";
  EXPECT_LT(times.size(), 256U);
  EXPECT_EQ(times.back(), 2000);
  EXPECT_EQ(times.front(), 2000 - static_cast<std::int64_t>(times.size()) + 1) << "a hole";
  EXPECT_LT(std::filesystem::file_size(path_), 512U << 10);  // closed: nothing is beside it
  EXPECT_THAT(Troubles(), IsEmpty());
}

TEST_F(JournalTest, IsReadableAfterItsWriterWasKilled) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  const std::string program = BinDir() + "/controller_journal_writer";
  const pid_t writer = fork();
  if (writer == 0) {
    dup2(ends[1], 1);
    execl(program.c_str(), program.c_str(), path_.c_str(), nullptr);
    _exit(127);
  }
  close(ends[1]);
  std::array<char, 6> said{};
  EXPECT_EQ(read(ends[0], said.data(), said.size()), 6) << "the writer did not get ready";
  kill(writer, SIGKILL);
  waitpid(writer, nullptr, 0);
  close(ends[0]);

  const auto times = Times(Read());
  ASSERT_GE(times.size(), 100U);
  for (std::size_t i = 0; i < times.size(); ++i) ASSERT_EQ(times[i], std::int64_t(i) + 1);
  { Journal(path_, Options()).Append(Entry(7)); }
  EXPECT_EQ(Read().size(), times.size() + 1);
  EXPECT_THAT(Troubles(), IsEmpty());
}

TEST_F(JournalTest, ReportsAJournalWithoutRecords) {
  const auto entries = ReadJournal(path_, 0, 1);
  ASSERT_FALSE(entries);
  EXPECT_THAT(entries.error().message, ::testing::HasSubstr(path_));
  EXPECT_FALSE(std::filesystem::exists(path_)) << "reading must not create it";
}

}  // namespace musher::journal_test
