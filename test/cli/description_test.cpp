#include "musher/cli/render/description.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>

#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/cli/robot.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::description_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class Describing : public ::testing::Test {
 protected:
  Describing() {
    setenv("TZ", "UTC", 1);
    tzset();
    legs_.name = "legs";
    legs_.machine = "dog";
    legs_.machine_state = "Active";
    legs_.machine_phase = "running";
    legs_.info = RobotStatus().actuators[0];
    legs_.info->target.clear();
    legs_.config = RobotConfig().actuators[0];
    legs_.config->command = {"musher-exec", "legs.toml"};
    legs_.config_file = "dog.toml";
    legs_.config_line = 9;
    legs_.on_this_host = true;
    legs_.now_wall_ns = 1'772'366'405'000'000'000;  // 2026-03-01 12:00:05
    legs_.process = ProcessFacts{{101, 5, 2.5, 12'300'000, 7},
                                 "musher-exec legs.toml",
                                 "/robot",
                                 legs_.now_wall_ns - 50'000'000'000,
                                 50,
                                 false};
    Happened("command_done", "legs: Active done after 3.2 ms", 5);
    legs_.log = {{"legs", legs_.now_wall_ns, LogLevel::kInfo, "walks"}};
    legs_.log_file = "/state/logs/legs.log";
  }

  void Happened(const std::string& event, const std::string& message, int seconds_ago) {
    msg::HistoryEntry entry;
    entry.wall_ns = legs_.now_wall_ns - seconds_ago * 1'000'000'000LL;
    entry.kind = "actuator";
    entry.actuator = "legs";
    entry.message = message;
    legs_.history.push_back(entry);
    legs_.events.push_back(event);
  }
  std::string Text() const { return DescriptionText(legs_, false); }
  std::vector<std::string> Commands() const {
    std::vector<std::string> commands;
    for (const Advice& step : AdviceFor(legs_)) commands.push_back(step.command);
    return commands;
  }

  Description legs_;
};

TEST_F(Describing, ShowsAllOnOneScreen) {
  legs_.reach = {{"LowPower", true, 0, "", true},
                 {"Error", false, 103, "ranks above"},
                 {"OTA", false, 103, "ranks above"}};
  EXPECT_EQ(
      Text(),
      "legs  of dog\n"
      "state         Active, for 5 s (since 2026-03-01 12:00:00.000); the machine is in Active "
      "(running)\n"
      "health        well (present); no heartbeat received\n"
      "process       pid 101, up 50 s (since 2026-03-01 11:59:15.000), CPU 5.0 % on average, "
      "12.3 MB, 7 threads\n"
      "              musher-exec legs.toml  in /robot\n"
      "restarts      0 restarts in a row; not restarted automatically\n"
      "config        dog.toml:9  stage 1, critical, protocol musher\n"
      "time limits   SetUp 0.001 s, TearDown 0.002 s, SelfCheck 0.003 s, Active 0.004 s, LowPower "
      "0.005 s, Error 0.006 s\n"
      "can go to     LowPower\n"
      "              not Error, OTA: ranks above (103 Robot: StateInvalid)\n"
      "last events\n"
      "2026-03-01 12:00:00.000  actuator legs: Active done after 3.2 ms\n"
      "last lines of /state/logs/legs.log\n"
      "2026-03-01 12:00:05.000  walks\n"
      "next\n"
      "  musher logs -f legs       watch what it prints\n"
      "  musher set LowPower legs  switch it alone\n");
}

TEST_F(Describing, SuggestsNoSwitchUpAndNoUpgradeOfOneActuator) {
  legs_.reach = {{"OTA", true, 0, "", true}, {"Active", true, 0, "", false}};
  const auto commands = Commands();
  EXPECT_FALSE(commands.empty());
  for (const std::string& command : commands) EXPECT_FALSE(command.starts_with("musher set"));
}

TEST_F(Describing, DoesNotClaimSinceWhenItIsInAStateThatItWasNotCommandedTo) {
  legs_.info->state = "Error";
  EXPECT_EQ(SinceOf(legs_), 0);
  EXPECT_THAT(Text(), HasSubstr("state         Error; the machine"));
}

TEST_F(Describing, NamesWhatIsWrongAndWhatToDo) {
  legs_.info->health = "hung";
  legs_.info->degraded = true;
  legs_.info->code = 107;
  legs_.info->message = "no checkpoint for 3000 ms";
  legs_.process->stopped = true;
  Happened("process_exited", "legs exited with code 3", 1);
  EXPECT_THAT(Text(), AllOf(HasSubstr("degraded\n"),
                            HasSubstr("why           no checkpoint for 3000 ms (107"),
                            HasSubstr("STOPPED by a signal"),
                            HasSubstr("last exit     2026-03-01 12:00:04.000  legs exited")));
  EXPECT_THAT(Commands(), ElementsAre("kill -CONT 101", "musher logs legs --level warning",
                                      "musher history --actuator legs", "musher restart legs"));
}

TEST_F(Describing, OfALatchedStopNamesItsRelease) {
  legs_.status.emplace();
  legs_.status->emergency_stop = 7;
  legs_.status->emergency_stop_by = "ann";
  EXPECT_THAT(Text(), HasSubstr("emergency stop latched, by ann"));
  EXPECT_THAT(Commands(), ElementsAre("musher estop --release"));
}

TEST_F(Describing, WithTheMachineDownShowsWhatTheFilesKnow) {
  legs_.info.reset();
  legs_.process.reset();
  legs_.machine_state.clear();
  legs_.why_no_machine = "down";
  EXPECT_THAT(Text(), AllOf(HasSubstr("state         not known\n"), HasSubstr("machine       down"),
                            HasSubstr("command       musher-exec legs.toml"), HasSubstr("walks")));
  EXPECT_THAT(Commands(), ElementsAre("musher logs legs", "musher up dog.toml"));
}

TEST_F(Describing, OfAnActuatorElsewhereClaimsNothingAboutItsProcess) {
  legs_.process.reset();
  legs_.on_this_host = false;
  legs_.log.clear();
  legs_.why_no_log = "the logs are on the host of the controller";
  EXPECT_THAT(Text(), AllOf(HasSubstr("pid 101 on another host"), HasSubstr("the logs are on")));
  EXPECT_THAT(Commands(), Not(::testing::Contains(HasSubstr("logs"))));
}

// The clock of the controller's computer was three hours behind: "for 3 h", after five seconds.
TEST_F(Describing, OfAControllerOfAnotherComputerDoesNotSayForHowLong) {
  legs_.history.front().wall_ns -= 3 * 3'600'000'000'000LL;
  legs_.same_clock = false;
  EXPECT_THAT(Text(),
              AllOf(HasSubstr(" by the clock of its controller"), Not(HasSubstr(", for "))));
}

// It said that CPU and memory are seen there only, and that the controller makes a log file.
TEST_F(Describing, OfAnActuatorOnAHostOfTheConfigNamesTheCommandsThatShowIt) {
  legs_.process.reset();
  legs_.on_this_host = false;
  legs_.config->host = "vision";
  legs_.log.clear();
  legs_.why_no_log = "its output is elsewhere";
  EXPECT_THAT(Text(), HasSubstr("pid 101 on host vision: `musher top` shows its CPU and memory\n"));
  EXPECT_THAT(Commands(), ::testing::Contains("musher logs -f legs"));
}

TEST(DescribeCommand, SaysWhereTheLogOfAnActuatorOnAnotherHostIs) {
  if (!SupportsHosts()) GTEST_SKIP() << "built without hosts";
  setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
  const TempFolder folder;
  std::string text = kRobotToml;
  const std::string eyes = "stage = 2\n";
  text.replace(text.find(eyes), eyes.size(),
               eyes + "command = [\"/opt/eyes\"]\nhost = \"vision\"\n");
  std::ofstream(folder / "dog.toml") << text << "[transport]\nprofile = \"lan\"\n"
                                     << "[host.vision]\naddress = \"10.0.0.2\"\n";
  const Ran ran = RunProgram({"describe", "eyes", "--config", folder / "dog.toml"});
  EXPECT_EQ(ran.exit, 3) << ran.err;
  EXPECT_THAT(ran.out,
              HasSubstr("its output is in the journal of host vision; `musher logs eyes`"));
  unsetenv("ROS_DOMAIN_ID");
}

TEST_F(Describing, CannotControlTheTerminal) {
  legs_.info->message = "\x1b[2J";
  legs_.process->command = "\x1b]0;x\x07";
  legs_.log.front().text = "\x1b[H";
  EXPECT_THAT(Text(), Not(HasSubstr("\x1b")));
}

TEST_F(Describing, IsADocumentForPrograms) {
  EXPECT_THAT(DescriptionJson(legs_),
              AllOf(HasSubstr(R"("actuator":"legs")"), HasSubstr(R"("since":"2026-03-01T12:00:00)"),
                    HasSubstr(R"("cpu_s":2.5)"), HasSubstr(R"("next":[{"command":"musher logs)")));
}

TEST(Ages, AreShort) {
  EXPECT_EQ(AgeText(-1), "0 s");
  EXPECT_EQ(AgeText(119), "119 s");
  EXPECT_EQ(AgeText(120), "2 min");
  EXPECT_EQ(AgeText(7200), "2 h");
  EXPECT_EQ(AgeText(200'000), "2 d");
}

}  // namespace musher::cli::description_test
