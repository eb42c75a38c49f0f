// The log takes stdout and stderr, which the fixture gives back.

#include "musher/cli/start/controller_log.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>

#include "musher/base/unique_fd.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli::controller_log_test {

namespace fs = std::filesystem;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;

constexpr Duration kWaitLimit = std::chrono::seconds(120);

class Log : public ::testing::Test {
 protected:
  ~Log() override {
    disk_works_.set_value();
    disk_.reset();
    std::fflush(stdout);
    dup2(stdout_.get(), STDOUT_FILENO);
    dup2(stderr_.get(), STDERR_FILENO);
    if (HasFailure()) std::printf("%s", Text().c_str());  // with what failed
  }
  std::string Text() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }
  // Until the test is over or sets disk_works_.
  void StallDisk() {
    disk_->Do("stall", [works = disk_works_.get_future().share()] {
      works.wait();
      return Ok();
    });
  }
  void LetDiskWork() {
    disk_works_.set_value();
    disk_works_ = {};
    EXPECT_TRUE(disk_->Flush(kWaitLimit));
  }

  const UniqueFd stdout_{dup(STDOUT_FILENO)};
  const UniqueFd stderr_{dup(STDERR_FILENO)};
  TempFolder folder_;
  const std::string path_ = folder_ / "state/controller.log";
  transport::LinuxEventLoop loop_;
  std::promise<void> disk_works_;
  std::unique_ptr<transport::DiskWriter> disk_ = std::make_unique<transport::DiskWriter>(loop_);
  ControllerLog log_{*disk_, path_};
};

TEST_F(Log, HasEachLineWithItsTimeAndCode) {
  log_.Write("robot is up");
  log_.Write("legs is lost", 42);
  ASSERT_TRUE(disk_->Flush(kWaitLimit));
  EXPECT_THAT(Text(), MatchesRegex("20..-..-.. ..:..:..\\.... info: robot is up\n"
                                   "20..-..-.. ..:..:..\\.... warning: legs is lost.*\n"));
}

TEST_F(Log, AlsoHasWhatIsPrinted) {
  log_.Write("robot is up");
  ASSERT_TRUE(disk_->Flush(kWaitLimit));
  ASSERT_GT(dprintf(STDERR_FILENO, "a library warns\n"), 0);
  EXPECT_THAT(Text(), EndsWith("a library warns\n"));
}

TEST_F(Log, DoesNotBlockTheLoopWhileTheDiskStallsAndReportsHowMuchItDropped) {
  StallDisk();
  const std::string line(1000, 'x');
  for (int i = 0; i < 2000; ++i) log_.Write(line + std::to_string(i));
  EXPECT_FALSE(fs::exists(path_));
  LetDiskWork();
  log_.Write("robot is up");
  ASSERT_TRUE(disk_->Flush(kWaitLimit));
  const std::string text = Text();
  EXPECT_LE(text.size(), 1'100'000U);
  EXPECT_THAT(text, HasSubstr("x0\n"));
  EXPECT_THAT(text, Not(HasSubstr("x1999\n")));
  const auto kept = std::count(text.begin(), text.end(), '\n') - 2;
  EXPECT_THAT(text, HasSubstr(" warning: " + std::to_string(2000 - kept) + " lines dropped here"));
  EXPECT_THAT(text, EndsWith(" info: robot is up\n"));
}

TEST_F(Log, ThatWasRemovedIsMadeAgain) {
  log_.Write("one");
  ASSERT_TRUE(disk_->Flush(kWaitLimit));
  fs::remove_all(folder_ / "state");
  log_.Write("two");
  ASSERT_TRUE(disk_->Flush(kWaitLimit));
  EXPECT_THAT(Text(), EndsWith(" info: two\n"));
  EXPECT_THAT(Text(), Not(HasSubstr("one")));
}

TEST_F(Log, KeepsWhatTheDiskDidNotTakeUntilItDoes) {
  std::ofstream(folder_ / "state") << "in the way";
  log_.Write("one");
  EXPECT_FALSE(disk_->Flush(kWaitLimit));
  fs::remove(folder_ / "state");
  EXPECT_TRUE(disk_->Flush(kWaitLimit));
  EXPECT_THAT(Text(), EndsWith(" info: one\n"));
}

}  // namespace musher::cli::controller_log_test
