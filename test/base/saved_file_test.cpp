// A small file that a loop replaces, on a disk that may not answer.

#include "musher/base/saved_file.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <filesystem>
#include <string>

#include "musher/base/files.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/test/support/wait.hpp"

namespace musher::saved_file_test {

using ::testing::HasSubstr;

class Saved : public ::testing::Test {
 protected:
  const TempFolder folder_;
  const std::string path_ = folder_ / "below/place";
};

TEST_F(Saved, IsOnDiskWhenReplaceReturns) {
  SavedFile file(path_);
  ASSERT_TRUE(file.Replace("one"));
  EXPECT_EQ(ReadFile(path_), "one");
  ASSERT_TRUE(file.Replace("two"));
  EXPECT_EQ(ReadFile(path_), "two");
  file.Remove();
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(Saved, ThatCannotBeWrittenSaysWhy) {
  SavedFile file("/proc/none/place");
  EXPECT_THAT(file.Replace("one").error().message, HasSubstr("/proc/none/place"));
}

// ReplaceFile() opens the draft beside it, and the pipe in its place has no reader.
TEST_F(Saved, HoldsNoLoopOnADiskThatDoesNotAnswerAndIsWrittenOnceItDoes) {
  std::filesystem::create_directories(folder_ / "below");
  const std::string draft = path_ + ".new";
  ASSERT_EQ(mkfifo(draft.c_str(), 0600), 0);
  SavedFile file(path_);
  EXPECT_THAT(file.Replace("one").error().message, HasSubstr("has not answered"));
  EXPECT_THAT(file.Replace("two").error().message, HasSubstr("has not answered"));
  const UniqueFd reader(open(draft.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  EXPECT_TRUE(testing::Until([&] { return file.Replace("three").ok(); }));
  EXPECT_EQ(ReadFile(path_), "three");
}

}  // namespace musher::saved_file_test
