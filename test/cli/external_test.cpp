// musher view, record and play run the programs beside the musher program.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "musher/cli/commands/external.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::external_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// A copy of musher in a folder of its own, and beside it programs that print their arguments.
class External : public ::testing::Test {
 protected:
  External() { fs::copy_file(BinDir() + "/musher", musher_); }

  void Beside(const std::string& program) const {
    std::ofstream(folder_ / program) << "#!/bin/sh\nprintf '<%s>' \"${0##*/}\" \"$@\"\n"
                                     << "printf ' in %s' \"$ROS_DOMAIN_ID$MUSHER_NAMESPACE\"\n"
                                     << "printf ' of %s' \"$MUSHER_MACHINE\"\n"
                                     << "exit 7\n";
    fs::permissions(folder_ / program, fs::perms::owner_all);
  }

  TempFolder folder_;
  const std::string musher_ = folder_ / "musher";
};

TEST_F(External, APersonGivesEveryArgumentToTheProgramBeside) {
  Beside("musher-record");
  const auto ran = testing::RunToEnd(
      {musher_, "record", "-o", "a b.mcap", "--topic=/chat", "--json", "--help", "-x"});
  EXPECT_EQ(ran.exit, 7);
  EXPECT_THAT(
      ran.out,
      HasSubstr("<musher-record><record><-o><a b.mcap><--topic=/chat><--json><--help><-x>"));
  EXPECT_EQ(ran.err, "");
}

TEST_F(External, PlayIsACommandOfTheRecorderAndViewAProgramOfItsOwn) {
  Beside("musher-record");
  Beside("musher-view");
  EXPECT_THAT(testing::RunToEnd({musher_, "play", "run.mcap"}).out,
              HasSubstr("<musher-record><play><run.mcap>"));
  EXPECT_THAT(testing::RunToEnd({musher_, "view"}).out, HasSubstr("<musher-view> in"));
  EXPECT_THAT(testing::RunToEnd({musher_, "help", "view"}).out,
              HasSubstr("<musher-view><--help> in"));
}

TEST_F(External, TheDomainAndNamespaceBeforeTheCommandReachTheProgram) {
  Beside("musher-view");
  const auto ran = testing::RunToEnd({musher_, "--domain", "7", "--namespace", "dog1", "view"});
  EXPECT_THAT(ran.out, HasSubstr("<musher-view> in 7dog1"));
}

// The page of another robot than the one that was named.
TEST_F(External, TheMachineBeforeTheCommandReachesTheProgram) {
  Beside("musher-view");
  Beside("musher-record");
  EXPECT_THAT(testing::RunToEnd({musher_, "--machine", "cat", "view"}).out,
              HasSubstr("<musher-view> in  of cat"));
  EXPECT_THAT(testing::RunToEnd({musher_, "--machine", "cat", "record"}).out, HasSubstr(" of cat"));
  EXPECT_THAT(testing::RunToEnd({"env", "MUSHER_MACHINE=dog", musher_, "view"}).out,
              HasSubstr(" of dog"));
}

TEST_F(External, AMissingProgramIsNamedWithItsPackage) {
  const auto found = FindExternal(folder_.path(), "musher-no-such-program");
  ASSERT_FALSE(found);
  EXPECT_THAT(found.error().message, HasSubstr("musher-no-such-program is neither in"));
  EXPECT_THAT(found.error().message, HasSubstr("install the package musher-view"));
}

}  // namespace musher::cli::external_test
