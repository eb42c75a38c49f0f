#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "musher/cli/config/limit_check.hpp"
#include "musher/cli/config/program_check.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/cli/robot.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::check_test {

using ::testing::HasSubstr;

class CheckCommand : public ::testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  const TempFolder folder_;
};

TEST_F(CheckCommand, PrintsTheContentsOfAValidConfig) {
  const Ran ran = RunProgram({"check", Write("dog.toml", kRobotToml)});
  EXPECT_EQ(ran.exit, 0);
  EXPECT_EQ(ran.out, "ok: 2 actuators, 6 states, 2 stages\n");
  EXPECT_EQ(ran.err, "");
}

TEST_F(CheckCommand, ReportsEveryFaultWithItsPosition) {
  const std::string file = Write("bad.toml",
                                 "[controller]\nactuators = [\"a\"]\nstates = [\"Actve\"]\n"
                                 "default_time = -1\ndefault_state = \"Uninitialized\"\n");
  const Ran ran = RunProgram({"check", file});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.out, HasSubstr(file + ":2:14: error: "));
  EXPECT_THAT(ran.out, HasSubstr(file + ":3:11: error: "));
  EXPECT_THAT(ran.out, HasSubstr(file + ":4:16: error: "));
  EXPECT_THAT(ran.out, Not(HasSubstr("ok: ")));
}

TEST_F(CheckCommand, ReportsAFaultOfTheRulesWithItsPositionInEitherFile) {
  const std::string config =
      Write("dog.toml", std::string(kRobotToml) + "\n[safety]\nrules = \"rules.txt\"\n");
  const Ran missing = RunProgram({"check", config});
  EXPECT_EQ(missing.exit, 2);
  EXPECT_THAT(missing.out, HasSubstr(config + ":21:1: error: safety.rules: " +
                                     folder_ / "rules.txt" + ": the file cannot be read"));
  const std::string rules = Write("rules.txt", "\nnever eyse Active\n");
  const Ran wrong = RunProgram({"check", config});
  EXPECT_EQ(wrong.exit, 2);
  EXPECT_THAT(wrong.out, HasSubstr(rules + ":2:7: error: "));
  EXPECT_THAT(wrong.out, HasSubstr("did you mean 'eyes'?"));
  Write("rules.txt", "never eyes Active while legs is LowPower\n");
  const Ran right = RunProgram({"check", config});
  EXPECT_EQ(right.exit, 0) << right.out;
}

// Of a config that is not valid itself, the actuators that a rule may name are not known.
TEST_F(CheckCommand, LeavesTheRulesOfAnInvalidConfigAlone) {
  Write("rules.txt", "never eyse Active\n");
  const Ran ran = RunProgram(
      {"check", Write("dog.toml", std::string(kRobotToml) + "[safety]\nrules = \"rules.txt\"\n"
                                                            "permit_ms = 1\n")});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.out, HasSubstr("safety.permit_ms"));
  EXPECT_THAT(ran.out, Not(HasSubstr("rules.txt")));
}

TEST_F(CheckCommand, LetsWarningsPass) {
  std::string text = kRobotToml;
  text.replace(text.find("critical = true"), 15, "critical = false");
  const Ran ran = RunProgram({"check", Write("dog.toml", text)});
  EXPECT_EQ(ran.exit, 0);
  EXPECT_THAT(ran.out, HasSubstr("warning: "));
  EXPECT_THAT(ran.out, HasSubstr("\nok: "));
}

TEST_F(CheckCommand, NamesThePlaceOfALogGroupThatThisHostDoesNotHave) {
  std::string text = kRobotToml;
  const auto at = text.find("[controller]\n") + std::string("[controller]\n").size();
  text.insert(at, "log_group = \"no_such_group\"\n");
  const auto line = 1 + std::count(text.begin(), text.begin() + std::ptrdiff_t(at), '\n');
  const std::string file = Write("dog.toml", text);
  const Ran ran = RunProgram({"check", file});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.out, HasSubstr(file + ":" + std::to_string(line) +
                                 ":1: error: controller.log_group: this host has no group "
                                 "'no_such_group'"));
  EXPECT_THAT(ran.out, Not(HasSubstr("ok: ")));
  text.replace(text.find("no_such_group"), 13, "root");
  EXPECT_EQ(RunProgram({"check", Write("dog.toml", text)}).exit, 0);
}

TEST_F(CheckCommand, RefusesAPriorityThatThisUserMayNotGive) {
  std::string text = kRobotToml;
  text += "command = [\"true\"]\n";
  const std::size_t at = text.size();
  text += "realtime_priority = 40\nnice = -5\n";
  const std::string file = Write("dog.toml", text);
  const auto config = ReadConfigFile(file).config;
  ASSERT_TRUE(config);
  Priorities user;
  user.highest_real_time = 20;
  const auto found = CheckLimits(*config, user);
  ASSERT_EQ(found.size(), 2U);
  const auto line = 1 + std::count(text.begin(), text.begin() + std::ptrdiff_t(at), '\n');
  EXPECT_EQ(found[0].line, line);
  EXPECT_THAT(FormatDiagnostic(found[0]),
              HasSubstr(".realtime_priority: this user may set 20 at most; start the "
                        "machine as root, or permit it by LimitRTPRIO= in the unit"));
  EXPECT_THAT(FormatDiagnostic(found[1]), HasSubstr(".nice: this user may set 0 at least"));
  user.highest_real_time = 40;
  user.lowest_nice = -5;
  EXPECT_TRUE(CheckLimits(*config, user).empty());
  EXPECT_TRUE(CheckLimits(*config, {true}).empty());
}

TEST_F(CheckCommand, WarnsOfKeysThatUpWouldRefuse) {
  const std::string file =
      Write("dog.toml", std::string(kRobotToml) + "[security]\nkeys = \"nokeys\"\n");
  const Ran ran = RunProgram({"check", file});
  EXPECT_EQ(ran.exit, 0);
  EXPECT_THAT(ran.out, HasSubstr("warning: in 'security': 'keys': "));
  EXPECT_THAT(ran.out, HasSubstr("nokeys/identity_ca.cert: No such file or directory"));
}

TEST_F(CheckCommand, ReportsAnEmptyProgramOnce) {
  std::string text = kRobotToml;
  text.insert(text.find("critical = true"), "command = [\"\"]\n");
  const Ran ran = RunProgram({"check", Write("dog.toml", text)});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.out, HasSubstr("expected a program, found an empty string"));
  EXPECT_THAT(ran.out, Not(HasSubstr("is a folder")));
}

TEST_F(CheckCommand, ChecksAllOfSeveralFiles) {
  const std::string good = Write("good.toml", kRobotToml);
  const std::string bad = Write("bad.toml", "x = 1\n");
  const Ran ran = RunProgram({"check", bad, good});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.out, HasSubstr(bad + ":1:1: error: "));
  EXPECT_THAT(ran.out, HasSubstr(good + ": ok: 2 actuators"));
  EXPECT_EQ(RunProgram({"check", good, good}).exit, 0);
}

TEST_F(CheckCommand, IsOneJsonDocumentWhateverTheInput) {
  const std::string bad = Write("bad.toml", "x = \xff\n");
  const Ran ran = RunProgram({"check", bad, folder_ / "none.toml", "--json"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.out, ::testing::StartsWith(R"({"valid":false,"diagnostics":[{"file":")"));
  EXPECT_THAT(ran.out, HasSubstr("none.toml"));
  EXPECT_EQ(std::count(ran.out.begin(), ran.out.end(), '\n'), 1);
  const Ran good = RunProgram({"check", "--json", Write("dog.toml", kRobotToml)});
  EXPECT_EQ(good.exit, 0);
  EXPECT_EQ(good.out, "{\"valid\":true,\"diagnostics\":[]}\n");
}

TEST_F(CheckCommand, FaultsAFolderAndAMissingFile) {
  EXPECT_EQ(RunProgram({"check", folder_.path()}).exit, 2);
  const Ran missing = RunProgram({"check", folder_ / "none.toml"});
  EXPECT_EQ(missing.exit, 2);
  EXPECT_THAT(missing.out, HasSubstr("none.toml: error: "));
}

TEST_F(CheckCommand, WarnsOfAConfigThatCannotBeUpgradedOnlyWhereUpgradesAreConfigured) {
  const char* warning = "dog.toml: warning: the machine has no state OTA, which upgrades need";
  EXPECT_THAT(RunProgram({"check", Write("dog.toml", kRobotToml)}).out, Not(HasSubstr("OTA")));
  const std::string manager = std::string(kRobotToml) + "[policy]\nmanager = true\n";
  EXPECT_THAT(RunProgram({"check", Write("dog.toml", manager)}).out, HasSubstr(warning));
  std::filesystem::create_directories(folder_ / "slots/a");
  Write("ota.toml", "");
  const Ran in_a_root = RunProgram({"check", Write("slots/a/dog.toml", kRobotToml)});
  EXPECT_EQ(in_a_root.exit, 0);
  EXPECT_THAT(in_a_root.out, HasSubstr(warning));
  std::string text = kRobotToml;
  for (std::size_t at = 0; (at = text.find("\"Error\"", at)) != std::string::npos; at += 14) {
    text.insert(at, "\"OTA\", ");
  }
  text.replace(text.find("5, 6]"), 5, "5, 6, 7]");
  EXPECT_EQ(RunProgram({"check", Write("slots/a/dog.toml", text)}).out,
            "ok: 2 actuators, 7 states, 2 stages\n");
}

class CheckedPrograms : public CheckCommand {
 protected:
  // What `check` says of legs with these lines in its table.
  Ran Check(const std::string& lines) const {
    std::string text = kRobotToml;
    text.insert(text.find("critical = true"), lines + "\n");
    return RunProgram({"check", Write("dog.toml", text)});
  }
};

TEST_F(CheckedPrograms, NamesAProgramThatIsNotThere) {
  const Ran ran = Check("command = [\"nosuchprogram\"]");
  EXPECT_EQ(ran.exit, 0);
  EXPECT_THAT(ran.out, HasSubstr("/dog.toml:12:1: warning: in 'actuator.legs': 'command': program "
                                 "'nosuchprogram' not found in PATH"));
}

TEST_F(CheckedPrograms, NamesAProgramThatIsNotExecutable) {
  const std::string file = Write("legs.sh", "#!/bin/sh\n");
  EXPECT_THAT(Check("command = [\"" + file + "\"]").out, HasSubstr(file + " is not executable"));
  EXPECT_THAT(Check("command = [\"./legs.sh\"]\ncwd = \".\"").out,
              HasSubstr("/legs.sh is not executable"));
}

TEST_F(CheckedPrograms, NamesAFileBesideTheConfigThatLacksItsPath) {
  Write("legs.sh", "#!/bin/sh\n");
  EXPECT_THAT(
      Check("command = [\"legs.sh\"]").out,
      HasSubstr("program 'legs.sh' not found in PATH; did you mean './legs.sh', the file in " +
                folder_.path() + "? With cwd = \".\" it is found from everywhere"));
}

TEST_F(CheckedPrograms, NamesAFolderThatIsNotThere) {
  const Ran ran = Check("command = [\"true\"]\ncwd = \"gone\"");
  EXPECT_THAT(ran.out, HasSubstr("/dog.toml:13:1: warning: in 'actuator.legs': 'cwd': folder not "
                                 "found: " +
                                 (folder_ / "gone")));
}

TEST_F(CheckedPrograms, AcceptsAnExistingProgram) {
  EXPECT_EQ(Check("command = [\"true\"]").out, "ok: 2 actuators, 6 states, 2 stages\n");
}

TEST_F(CheckedPrograms, AreCheckedAlsoIfTheConfigHasAnError) {
  const std::string world = Write("musher-world",
                                  "#!/bin/sh\necho \"$3:1:2: error: of the state config\"\n"
                                  "echo 'scene.toml:3:4: error: of the scene'\nexit 2\n");
  std::filesystem::permissions(world, std::filesystem::perms::owner_all);
  const Ran ran = Check("command = [\"nosuchprogram\"]\non_lost = \"Gone\"\n");
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.out, HasSubstr("unknown state \"Gone\""));
  EXPECT_THAT(ran.out, HasSubstr("program 'nosuchprogram' not found in PATH"));
  const Ran module = Check("command = [\"" + world + "\"]\non_lost = \"Gone\"\n");
  EXPECT_THAT(module.out, HasSubstr("scene.toml:3:4: error: of the scene"));
  EXPECT_THAT(module.out, Not(HasSubstr("of the state config")));
}

TEST_F(CheckedPrograms, GiveTheirWarnings) {
  const std::string program =
      Write("musher-exec", "#!/bin/sh\necho 'a hint'\necho 'legs.toml:1:1: warning: no stop'\n");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  const Ran ran = Check("command = [\"" + program + "\"]");
  EXPECT_EQ(ran.exit, 0);
  EXPECT_THAT(ran.out, HasSubstr("/dog.toml:12:1: warning: in 'actuator.legs': 'command': "
                                 "legs.toml:1:1: warning: no stop\nok: 2 actuators"));
}

// A module of one's own, whose name begins like those of Musher's, started and ran for ever.
TEST_F(CheckedPrograms, AreNotRunUnlessTheyAreMushersOwn) {
  const std::string program = Write("musher-gripper", "#!/bin/sh\ntouch \"$0\".ran\n");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  EXPECT_EQ(Check("command = [\"" + program + "\"]").out, "ok: 2 actuators, 6 states, 2 stages\n");
  EXPECT_FALSE(std::filesystem::exists(program + ".ran"));
}

TEST_F(CheckedPrograms, ThatFailWithoutAMessageAreNamed) {
  const std::string program = Write("musher-world", "#!/bin/sh\nkill -SEGV $$\n");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  const Ran ran = Check("command = [\"" + program + "\"]");
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.out, HasSubstr("--check: killed by SIGSEGV, without a message"));
}

TEST_F(CheckedPrograms, HaveATimeToEndIn) {
  const std::string program = Write("musher-world", "#!/bin/sh\nexec tail -f /dev/null\n");
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  std::string text = kRobotToml;
  text.insert(text.find("critical = true"), "command = [\"" + program + "\"]\n");
  const auto config = ReadConfigFile(Write("dog.toml", text)).config;
  ASSERT_TRUE(config);
  const auto found = CheckPrograms(*config, Milliseconds(100));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].message,
            "in 'actuator.legs': 'command': " + program + " --check did not exit within 100 ms");
}

TEST_F(CheckedPrograms, HoldBehindASymbolicLinkWhereUpStartsThem) {
  std::filesystem::create_directory(folder_ / "real");
  std::string text = kRobotToml;
  text.insert(text.find("critical = true"), "command = [\"true\"]\ncwd = \"work\"\n");
  std::filesystem::create_symlink(Write("real/dog.toml", text), folder_ / "link.toml");
  std::filesystem::create_directory(folder_ / "work");  // beside the link
  const Ran ran = RunProgram({"check", folder_ / "link.toml"});
  EXPECT_EQ(ran.out, "ok: 2 actuators, 6 states, 2 stages\n");
}

// It started, and was absent for ever.
TEST_F(CheckedPrograms, ThatAreRos2NodesAreNamedWhereTheyCannotMeetTheMachine) {
  for (const char* name : {"CYCLONEDDS_URI", "RMW_IMPLEMENTATION", "ROS_LOCALHOST_ONLY",
                           "ROS_AUTOMATIC_DISCOVERY_RANGE"}) {
    unsetenv(name);
  }
  const std::string node = "protocol = \"ros2_lifecycle\"\ncommand = [\"true\"]";
  EXPECT_EQ(Check(node).out, "ok: 2 actuators, 6 states, 2 stages\n");
  const Ran ran = Check(node + "\nenv = { ROS_LOCALHOST_ONLY = \"1\" }");
  EXPECT_EQ(ran.exit, 0);
  EXPECT_THAT(ran.out,
              HasSubstr("warning: in 'actuator.legs': the ROS 2 node does not discover the "
                        "machine: ROS_LOCALHOST_ONLY is 1"));
}

TEST_F(CheckedPrograms, ThatAPersonStartsMayNeedSettingsInTheShell) {
  unsetenv("CYCLONEDDS_URI");
  setenv("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp", 1);
  const Ran ran = Check("protocol = \"ros2_lifecycle\"");
  unsetenv("RMW_IMPLEMENTATION");
  EXPECT_THAT(ran.out, HasSubstr("a ROS 2 node that is started in this shell does not discover "
                                 "the machine: CYCLONEDDS_URI is not set"));
}

}  // namespace musher::cli::check_test
