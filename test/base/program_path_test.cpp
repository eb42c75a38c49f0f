#include "musher/base/program_path.hpp"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "musher/test/support/temp_folder.hpp"

namespace musher::program_path_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;

class Path : public ::testing::Test {
 protected:
  ~Path() override { setenv("PATH", before_.c_str(), 1); }

  std::string Program(const std::string& name, fs::perms permissions = fs::perms::owner_all) {
    std::ofstream(folder_ / name) << "#!/bin/sh\n";
    fs::permissions(folder_ / name, permissions);
    return folder_ / name;
  }

  TempFolder folder_;
  const std::string before_ = std::getenv("PATH");
};

TEST(OwnProgram, IsTheFileOfThisProcess) {
  EXPECT_EQ(OwnProgram().filename(), "base_test");
  EXPECT_TRUE(fs::is_regular_file(OwnProgram()));
}

TEST_F(Path, HasTheUsualFoldersWhereTheEnvironmentHasNone) {
  unsetenv("PATH");
  EXPECT_EQ(SearchPath(), "/usr/local/bin:/usr/bin:/bin");
  PutFirstInPath("/opt/dog");
  EXPECT_EQ(SearchPath(), "/opt/dog:/usr/local/bin:/usr/bin:/bin");
}

TEST_F(Path, GetsAFolderBeforeTheOthers) {
  PutFirstInPath("/opt/dog");
  EXPECT_EQ(SearchPath(), "/opt/dog:" + before_);
}

TEST_F(Path, GivesTheCandidatesInItsOrderAndTheWorkingDirectoryForAnEmptyEntry) {
  EXPECT_THAT(CandidatesInPath("bark", "/a:/b"), ElementsAre("/a/bark", "/b/bark"));
  EXPECT_THAT(CandidatesInPath("bark", "/a::"), ElementsAre("/a/bark", "./bark", "./bark"));
  EXPECT_THAT(CandidatesInPath("bark", ""), ElementsAre("./bark"));
}

TEST_F(Path, FindsTheFirstProgramThatMayBeExecuted) {
  const std::string bark = Program("bark");
  fs::create_directories(folder_ / "first/bark");  // a folder is no program
  EXPECT_EQ(FindInPath("bark", folder_ / "first" + ":" + folder_.path()), bark);
  EXPECT_EQ(FindInPath("bark", "/nowhere"), "");
  EXPECT_EQ(FindInPath("bark", ":" + folder_.path() + ":"), bark)
      << "not one of the working directory, where any user may have put it";
  Program("text", fs::perms::owner_read);
  EXPECT_EQ(FindInPath("text", folder_.path()), "");
}

TEST_F(Path, OfThisProcessIsSearchedByDefault) {
  EXPECT_EQ(FindInPath("musher-test-bark"), "");
  const std::string bark = Program("musher-test-bark");
  PutFirstInPath(folder_.path());
  EXPECT_EQ(FindInPath("musher-test-bark"), bark);
}

}  // namespace musher::program_path_test
