#include "musher/base/files.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>

#include "musher/test/support/temp_folder.hpp"

namespace musher::transport::files_test {

using ::testing::IsEmpty;
using ::testing::IsSupersetOf;

TEST(Files, AreReadWhole) {
  const std::string bytes = std::string(200'000, 'x') + '\0' + "end";
  const std::string file = ::testing::TempDir() + "/files_test_" + std::to_string(getpid());
  std::ofstream(file, std::ios::binary) << bytes;
  EXPECT_EQ(ReadFile(file), bytes);
  unlink(file.c_str());
  EXPECT_EQ(ReadFile(file), "");
}

// As a file of /proc whose process exits between opening and reading.
TEST(Files, WhoseReadingFailsAreEmptyAndThrowNothing) {
  EXPECT_EQ(ReadFile("/proc/self"), "");
  const pid_t pid = fork();
  if (pid == 0) {
    while (true) pause();
  }
  const std::string environment = "/proc/" + std::to_string(pid) + "/environ";
  kill(pid, SIGKILL);
  waitpid(pid, nullptr, 0);
  EXPECT_EQ(ReadFile(environment), "");
}

TEST(Files, AFolderIsReadAsFarAsItCanBe) {
  EXPECT_THAT(EntriesOf("/proc/self"),
              IsSupersetOf<std::filesystem::path>({"/proc/self/stat", "/proc/self/environ"}));
  EXPECT_THAT(EntriesOf("/proc/self/no such folder"), IsEmpty());
  std::error_code error;
  EXPECT_THAT(EntriesOf("/proc/self/stat", error), IsEmpty());
  EXPECT_TRUE(error);
}

// As another user may have left it.
TEST(Files, OnlyARegularFileIsOpenedAndNoLinkIsFollowed) {
  const std::string file = ::testing::TempDir() + "/files_test_" + std::to_string(getpid());
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  EXPECT_FALSE(OpenRegular(file).valid());
  EXPECT_EQ(errno, EINVAL);
  unlink(file.c_str());
  ASSERT_EQ(symlink("/proc/self/status", file.c_str()), 0);
  EXPECT_FALSE(OpenRegular(file).valid());
  unlink(file.c_str());
  EXPECT_FALSE(OpenRegular(file).valid());
  EXPECT_EQ(errno, ENOENT);
  std::ofstream(file) << "x";
  EXPECT_TRUE(OpenRegular(file).valid());
  unlink(file.c_str());
}

// Processes that exit while they are examined.
TEST(Files, ThatVanishWhileTheyAreReadThrowNothing) {
  for (int i = 0; i < 300; ++i) {
    const pid_t pid = fork();
    if (pid == 0) _exit(0);
    const std::string process = "/proc/" + std::to_string(pid);
    while (waitpid(pid, nullptr, WNOHANG) == 0) {
      EntriesOf(process + "/fd");
      ReadFile(process + "/stat");
    }
  }
}

class ReplacedFile : public ::testing::Test {
 protected:
  std::string Content() const { return ReadFile(file_); }

  const TempFolder folder_;
  const std::string file_ = folder_ / "epoch";
};

TEST_F(ReplacedFile, HasTheNewContentAndLeavesNoDraft) {
  ASSERT_TRUE(ReplaceFile(file_, "a longer first content", {.mode = 0600}));
  ASSERT_TRUE(ReplaceFile(file_, "second"));
  EXPECT_EQ(Content(), "second");
  EXPECT_EQ(EntriesOf(folder_.path()).size(), 1U);
}

TEST_F(ReplacedFile, KeepsTheOldContentWhenTheNewOneCannotBeWritten) {
  ASSERT_TRUE(ReplaceFile(file_, "old"));
  std::filesystem::create_directory(file_ + ".new");
  const auto replaced = ReplaceFile(file_, "new");
  ASSERT_FALSE(replaced);
  EXPECT_EQ(replaced.error().message, "can't save " + file_ + ": Is a directory");
  EXPECT_EQ(Content(), "old");
}

TEST_F(ReplacedFile, IsReadWholeByAReaderThatHasOpenedItBefore) {
  ASSERT_TRUE(ReplaceFile(file_, "old", {.synced = false}));
  std::ifstream reader(file_);
  ASSERT_TRUE(ReplaceFile(file_, "new", {.synced = false}));
  std::string read;
  reader >> read;
  EXPECT_EQ(read, "old");
  EXPECT_EQ(Content(), "new");
}

}  // namespace musher::transport::files_test
