#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "musher/cli/config/config_diff.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/cli/robot.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::diff_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// The robot with some words replaced.
std::string With(const std::string& words, const std::string& by) {
  std::string text = kRobotToml;
  const std::size_t at = text.find(words);
  if (at == std::string::npos) {
    ADD_FAILURE() << "the robot has no '" << words << "'";
    return text;
  }
  return text.replace(at, words.size(), by);
}

MachineConfig Read(const std::string& text) {
  const ConfigReading reading = ReadConfigText(text, "dog.toml");
  for (const Diagnostic& d : reading.diagnostics) {
    if (!reading.config) ADD_FAILURE() << FormatDiagnostic(d);
  }
  return reading.config.value_or(MachineConfig{});
}

ConfigDiff DiffTo(const std::string& text) {
  return Compare(RobotConfig(), Read(text));
}

// "actuator.legs/stage: 1 > 2"
std::vector<std::string> Changes(const ConfigDiff& diff) {
  std::vector<std::string> lines;
  for (const ConfigChange& change : diff.changes) {
    lines.push_back(change.table + "/" + change.key + ": " + change.before + " > " + change.after);
  }
  return lines;
}

TEST(Compare, IgnoresCommentsTheOrderOfKeysAndStatedDefaults) {
  std::string text =
      With("critical = true", "# so that it walks\nrestart = \"no\"\ncritical = true");
  text = "# a robot\n" + text;
  const std::string after = "stage = 2\nafter = [\"legs\"]";
  text.replace(text.find(after), after.size(), "after = [\"legs\"]\nstage = 2");
  EXPECT_THAT(Changes(DiffTo(text)), IsEmpty());
}

TEST(Compare, NamesTimesByTheirStateAndStatesBySetDifference) {
  std::string text = With("\"LowPower\", \"Error\"]\ntimes = [1, 2, 3, 4, 5, 6]",
                          "\"Error\"]\ntimes = [1, 2, 3, 9, 6]");
  EXPECT_THAT(
      Changes(DiffTo(text)),
      ElementsAre("actuator.legs/states: LowPower > ", "actuator.legs/times (Active): 4 ms > 9 ms",
                  "actuator.legs/on_controller_lost: LowPower > Error",
                  "actuator.legs/times (LowPower): 5 ms > "));
}

TEST(Compare, AKeyThatOnlyTheControllerReadsNeedsATakeover) {
  const ConfigDiff diff = DiffTo(With("stage = 2\nafter = [\"legs\"]", "stage = 2"));
  EXPECT_THAT(Changes(diff), ElementsAre("actuator.eyes/after: legs > "));
  EXPECT_FALSE(diff.needs_new_start);
  EXPECT_THAT(diff.restarts, IsEmpty());
}

TEST(Compare, AKeyThatTheActuatorReadsNeedsItsRestart) {
  const ConfigDiff diff = DiffTo(With("critical = true", "critical = true\ncheckpoint_ms = 500"));
  EXPECT_THAT(Changes(diff), ElementsAre("actuator.legs/checkpoint_ms: none > 500 ms"));
  EXPECT_THAT(diff.restarts, ElementsAre("legs"));
}

TEST(Compare, ANameOrAProfileNeedsANewStart) {
  EXPECT_TRUE(DiffTo(With("name = \"dog\"", "name = \"cat\"")).needs_new_start);
  EXPECT_TRUE(DiffTo(std::string(kRobotToml) + "[transport]\nprofile = \"lan\"\n").needs_new_start);
}

TEST(Compare, ARemovedActuatorIsLeftBehindAndANewOneIsOneChange) {
  std::string text = With("\"legs\", \"eyes\"", "\"legs\", \"ears\"");
  text.replace(text.find("[actuator.eyes]"), 15, "[actuator.ears]");
  const ConfigDiff diff = DiffTo(text);
  EXPECT_THAT(Changes(diff), ElementsAre("actuator.ears/:  > ", "actuator.eyes/:  > "));
  EXPECT_EQ(diff.changes[0].kind, ConfigChange::Kind::kAdded);
  EXPECT_EQ(diff.changes[1].kind, ConfigChange::Kind::kRemoved);
  EXPECT_THAT(diff.left_behind, ElementsAre("eyes"));
  EXPECT_THAT(diff.restarts, IsEmpty());
}

TEST(Compare, ACapabilityConcernsTheActuatorsThatItUses) {
  const std::string text = std::string(kRobotToml) + "[capability.walk]\nactuators = [\"legs\"]\n";
  const ConfigDiff diff = DiffTo(text);
  EXPECT_THAT(Changes(diff), ElementsAre("capability.walk/:  > "));
  EXPECT_THAT(diff.restarts, ElementsAre("legs"));
}

TEST(Compare, ShowsTransitionsOnlyWhereAFileHasItsOwn) {
  const std::string own = "[[transition]]\nfrom = \"Active\"\nto = [\"LowPower\", \"Error\"]\n";
  const ConfigDiff diff = DiffTo(kRobotToml + own);
  EXPECT_THAT(Changes(diff), ElementsAre("transition/:  > "));
  const std::string more = "[[transition]]\nfrom = \"LowPower\"\nto = \"Active\"\n";
  EXPECT_THAT(Changes(Compare(Read(kRobotToml + own), Read(kRobotToml + own + more))),
              ElementsAre("transition/from → to:  > LowPower → Active"));
}

TEST(Compare, RulesNeedATakeover) {
  const std::string robot = std::string(kRobotToml) + "[safety]\npermit_ms = 500\n";
  const ConfigDiff added = Compare(Read(robot), Read(robot + "rules = \"/etc/rules.txt\"\n"));
  EXPECT_THAT(Changes(added), ElementsAre("safety/rules: none > /etc/rules.txt"));
  EXPECT_FALSE(added.needs_new_start);
  const ConfigDiff alone = DiffTo(std::string(kRobotToml) + "[safety]\nrules = \"rules.txt\"\n");
  EXPECT_THAT(Changes(alone), ElementsAre("safety/:  > "));
  EXPECT_FALSE(alone.needs_new_start);
}

TEST(Compare, ShowsTheTablesThatTheFileHas) {
  const ConfigDiff diff = DiffTo(std::string(kRobotToml) +
                                 "[policy.battery]\nprotected_at = 30\n[policy.reboot]\ncommand = "
                                 "[\"reboot\"]\n[view]\nport = 9000\n[ros2]\nrosout = false\n");
  EXPECT_THAT(Changes(diff), ElementsAre("view/:  > ", "policy/:  > ", "policy.battery/:  > ",
                                         "policy.reboot/:  > ", "ros2/rosout: true > false"));
}

class DiffCommand : public ::testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories(std::filesystem::path(folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  const TempFolder folder_;
};

TEST_F(DiffCommand, ExitsLikeDiff) {
  const std::string dog = Write("dog.toml", kRobotToml);
  const Ran same = RunProgram({"diff", dog, dog});
  EXPECT_EQ(same.exit, 0);
  EXPECT_THAT(same.out, HasSubstr("describe the same machine"));
  const std::string other = Write("other.toml", With("default_time = 1000", "default_time = 7"));
  const Ran differs = RunProgram({"diff", dog, other});
  EXPECT_EQ(differs.exit, 1);
  EXPECT_EQ(differs.out,
            "[controller]\n  default_time: 1000 ms → 7 ms\nwhile the robot runs: "
            "`musher up --detach --takeover " +
                other + "`\n");
  EXPECT_EQ(RunProgram({"diff", dog, folder_ / "none.toml"}).exit, 2);
  EXPECT_EQ(RunProgram({"diff", dog, Write("bad.toml", "x = 1\n")}).exit, 2);
  EXPECT_EQ(RunProgram({"diff", dog, dog, dog}).exit, 2);
  EXPECT_EQ(RunProgram({"diff"}).exit, 2);
}

// The second file is read as if it replaced the first one.
TEST_F(DiffCommand, FilesInOtherFoldersWithOtherNamesMayBeTheSameMachine) {
  std::string text = With("name = \"dog\"\n", "");
  text.replace(text.find("critical = true"), 15,
               "critical = true\ncommand = [\"./legs\"]\ncwd = \".\"");
  const Ran same = RunProgram({"diff", Write("a/dog.toml", text), Write("b/old.toml", text)});
  EXPECT_EQ(same.exit, 0) << same.out;
}

TEST_F(DiffCommand, IsOneJsonDocument) {
  const Ran ran = RunProgram({"--json", "diff", Write("a.toml", kRobotToml),
                              Write("b.toml", With("name = \"dog\"", "name = \"cat\""))});
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.out, ::testing::StartsWith(R"({"same":false,"before":")"));
  EXPECT_THAT(ran.out, HasSubstr(R"({"table":"controller","key":"name","change":"changed",)"
                                 R"("before":"dog","after":"cat","effect":"new_start"})"));
  EXPECT_THAT(ran.out, HasSubstr(R"("needs_new_start":true,"restarts":[],"left_behind":[]})"));
}

TEST_F(DiffCommand, ShowsWhatNeedsANewStart) {
  const Ran ran = RunProgram({"diff", Write("a.toml", kRobotToml),
                              Write("b.toml", With("name = \"dog\"", "name = \"cat\""))});
  EXPECT_THAT(ran.out, HasSubstr("needs a new start ([controller] name, [controller] state_dir): "
                                 "`musher down`, then `musher up "));
  EXPECT_THAT(ran.out, Not(HasSubstr("takeover")));
}

}  // namespace musher::cli::diff_test
