// The file of the progress, which a thread writes.

#include "musher/modules/meilin/mission/progress_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/test/support/temp_folder.hpp"

namespace musher::meilin::progress_file_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(TheFileOfTheProgress, HasTheLastTextWhenItIsReadAndAfterTheProcess) {
  const TempFolder folder;
  std::vector<std::string> log;
  {
    ProgressFile file([&log](const std::string& line) { log.push_back(line); });
    EXPECT_EQ(file.Read(), "");
    file.Write("nowhere");
    file.Open(folder / "progress.toml");
    EXPECT_EQ(file.Read(), "");
    for (int i = 0; i < 20; ++i) file.Write("next = " + std::to_string(i) + "\n");
    EXPECT_EQ(file.Read(), "next = 19\n");
    file.Write("next = 20\n");
  }
  EXPECT_EQ(ReadFile(folder / "progress.toml"), "next = 20\n");
  EXPECT_TRUE(log.empty());
}
TEST(TheFileOfTheProgress, SaysOnceThatItCannotBeWritten) {
  std::vector<std::string> log;
  {
    ProgressFile file([&log](const std::string& line) { log.push_back(line); });
    file.Open("/proc/nowhere/progress.toml");
    file.Write("a");
    file.Write("b");
  }
  EXPECT_THAT(log, ElementsAre(HasSubstr("the progress is not saved: ")));
}

}  // namespace musher::meilin::progress_file_test
