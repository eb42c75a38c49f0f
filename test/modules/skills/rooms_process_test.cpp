// A machine of real programs in the rooms: world, planner, controller and the skills of a robot.
// Its client is plain C and has only ROS 2's wire.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::skills::rooms_process_test {

namespace fs = std::filesystem;

using ::testing::HasSubstr;
using ::testing::MatchesRegex;

constexpr const char* kMachine = R"([controller]
actuators = ["world", "planner_server", "controller_server", "jetbot_0"]
states = ["SetUp", "TearDown", "SelfCheck", "Active"]
default_time = 15000
default_state = "Uninitialized"
name = "rooms"
clock = "topic"
)";

class Rooms : public ::testing::Test {
 protected:
  Rooms() {
    testing::AdoptOrphans();
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    setenv("XDG_STATE_HOME", (folder_ / "state").c_str(), 1);
    setenv("PATH", (BinDir() + ":" + getenv("PATH")).c_str(), 1);
    fs::copy(SourceDir() + "/config", folder_.path(), fs::copy_options::recursive);
    std::ofstream config(Config());
    config << kMachine;
    Write(config, "world", "[\"musher-world\", \"scenes/rooms.toml\"]", "");
    Write(config, "planner_server", "[\"musher-planner\", \"navigation/planner.toml\"]",
          "\"world\"");
    Write(config, "controller_server", "[\"musher-controller\", \"navigation/controller.toml\"]",
          "\"world\"");
    Write(config, "jetbot_0", "[\"musher-skills\", \"skills/jetbot_0.toml\"]",
          "\"planner_server\", \"controller_server\"");
  }
  // Nothing that the test started outlives it.
  ~Rooms() override {
    static_cast<void>(Musher({"down", "--timeout", "10"}));
    for (const pid_t pid : testing::Children()) kill(pid, SIGKILL);
    testing::AwaitNoChildren();
  }

  std::string Config() const { return folder_ / "machine.toml"; }
  static void Write(std::ostream& config, const std::string& name, const std::string& command,
                    const std::string& after) {
    config << "[actuator." << name << "]\n"
           << "states = [\"SetUp\", \"TearDown\", \"SelfCheck\", \"Active\"]\n"
           << "times = [15000, 15000, 15000, 15000]\ncwd = \".\"\ncommand = " << command
           << "\nafter = [" << after << "]\n";
  }
  static testing::Ended Musher(std::vector<std::string> words) {
    words.insert(words.begin(), BinDir() + "/musher");
    return testing::RunToEnd(words);
  }
  // What the client prints of a goal of nav_2d. `more`: "cancel".
  static std::string Navigate(const std::string& place, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{BinDir() + "/skill_client_peer",
                                   std::to_string(transport::TestDomain()),
                                   "jetbot_0/skill_execution",
                                   "nav_2d",
                                   "goal_pos",
                                   place};
    words.insert(words.end(), more.begin(), more.end());
    const testing::Ended ended = testing::RunToEnd(words);
    EXPECT_EQ(ended.exit, 0) << ended.out << ended.err;
    return ended.out;
  }

  const TempFolder folder_;
};

TEST_F(Rooms, LetAPlainClientNavigateARobot) {
  const testing::Ended up = Musher({"up", Config(), "--detach"});
  ASSERT_EQ(up.exit, 0) << up.out << up.err;
  EXPECT_THAT(Navigate("[1.8, 1.2, 0]"),
              MatchesRegex("offered by jetbot_0 on /jetbot_0/skill_execution: [^\n]*nav_2d[^\n]*\n"
                           "accepted\n"
                           "feedback: processing: [^\n]*\n"
                           "result of status 4: true completed: Reached goal .100%.\n"));
  EXPECT_THAT(Navigate("[11, 8]"),
              HasSubstr("result of status 6: false failed: Planning failed: no way is wide enough "
                        "for the robot: the goal (11.00, 8.00) or the start is walled in"));
  const std::string cancelled = Navigate("[4, 1.2]", {"cancel"});
  EXPECT_THAT(cancelled, HasSubstr("cancel: code 0\n"));
  EXPECT_THAT(cancelled,
              HasSubstr("result of status 5: false cancelled: Cancelled: by its client"));
}

}  // namespace musher::skills::rooms_process_test
