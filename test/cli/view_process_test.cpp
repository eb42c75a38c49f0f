// What the page of a config's [view] is started with. The program is a script that says it.

#include "musher/cli/start/view_process.hpp"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "musher/base/files.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli::view_process_test {

using ::testing::HasSubstr;
using ::testing::Not;

class APageOfAConfig : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* transport = std::getenv("MUSHER_TRANSPORT");
    transport_ = transport == nullptr ? "" : transport;
    unsetenv("MUSHER_TRANSPORT");
    const std::string program = folder_ / kViewProgram;
    std::ofstream(program) << "#!/bin/sh\n"
                              "echo \"$*, MUSHER_TRANSPORT=$MUSHER_TRANSPORT"
                              " MUSHER_KEYS=$MUSHER_KEYS.\"\n"
                              "exec sleep 60\n";
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    std::filesystem::create_directories(folder_ / "logs");
    path_ = std::getenv("PATH");
    setenv("PATH", (folder_.path() + ":" + path_).c_str(), 1);
    config_.name = "dog";
    config_.state_dir = folder_.path();
    config_.view.emplace();
  }
  void TearDown() override {
    setenv("PATH", path_.c_str(), 1);
    unsetenv("MUSHER_TRANSPORT");
    if (!transport_.empty()) setenv("MUSHER_TRANSPORT", transport_.c_str(), 1);
  }
  // The line of the script.
  std::string StartedWith() {
    transport::LinuxEventLoop loop;
    const ViewProcess view(loop, config_, [](const std::string& why) { ADD_FAILURE() << why; });
    const std::string log = config_.state_dir + "/logs/" + kViewProgram + ".log";
    const auto poll = loop.Every(Milliseconds(5), [] {});
    EXPECT_TRUE(loop.RunUntil([&log] { return ReadFile(log).ends_with(".\n"); },
                              loop.Now() + std::chrono::seconds(120)));
    return ReadFile(log);
  }

  TempFolder folder_;
  std::string path_;
  std::string transport_;
  MachineConfig config_;
};

TEST_F(APageOfAConfig, ReachesTheHostsThatItsControllerReaches) {
  config_.transport = TransportProfile::kLan;
  config_.interfaces = {"eth7", "wlan7"};
  const std::string started = StartedWith();
  EXPECT_THAT(started, HasSubstr("MUSHER_TRANSPORT=lan "));
  EXPECT_THAT(started, HasSubstr(" --interface eth7 --interface wlan7"));
  EXPECT_THAT(started, HasSubstr(" --machine dog"));
}

TEST_F(APageOfAConfig, StaysOnItsHostWhereTheEnvironmentSaysSo) {
  config_.transport = TransportProfile::kLan;
  setenv("MUSHER_TRANSPORT", "local", 1);
  EXPECT_THAT(StartedWith(), HasSubstr("MUSHER_TRANSPORT=local "));
}

TEST_F(APageOfAConfig, OfTheProfileLocalNamesNoInterface) {
  const std::string started = StartedWith();
  EXPECT_THAT(started, HasSubstr("MUSHER_TRANSPORT=local MUSHER_KEYS=."));
  EXPECT_THAT(started, Not(HasSubstr("--interface")));
}

}  // namespace musher::cli::view_process_test
