#include "musher/modules/exec/exec_config.hpp"

#include <gmock/gmock.h>

#include <string>

#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/test/support/diagnostics.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::exec::exec_config_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

ActuatorConfig Audio() {
  ActuatorConfig audio;
  audio.name = "audio";
  audio.states = {"SetUp", "TearDown", "SelfCheck", "Active"};
  return audio;
}

Parsed<ExecConfig> Read(const std::string& text) {
  return ReadExecText(text, "/robot/audio.toml", Audio());
}

TEST(ExecConfig, HasTheValuesOfTheFile) {
  const Parsed<ExecConfig> reading = Read(R"(
module = 5000
stop_ms = 700
cwd = "work"
[state.SetUp]
start = ["server", "--port", "80"]
run = ["./wait", "80", "80"]
[state.SelfCheck]
shell = "test -e /dev/snd && true"
[emergency_stop]
run = ["./mute"]
time_ms = 300
end_program = true
)");
  ASSERT_TRUE(reading.config);
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  EXPECT_EQ(reading.config->module, 5000);
  EXPECT_EQ(reading.config->stop_time, Milliseconds(700));
  EXPECT_EQ(reading.config->cwd, "/robot/work");
  ASSERT_EQ(reading.config->states.size(), 2U);
  EXPECT_THAT(reading.config->states.at("SetUp").start, ElementsAre("server", "--port", "80"));
  EXPECT_THAT(reading.config->states.at("SetUp").run, ElementsAre("/robot/wait", "80", "80"));
  EXPECT_THAT(reading.config->states.at("SelfCheck").run,
              ElementsAre("/bin/sh", "-c", "test -e /dev/snd && true"));
  EXPECT_EQ(reading.config->emergency_stop,
            (EmergencyStopAction{{"/robot/mute"}, Milliseconds(300), true}));
  EXPECT_EQ(WhyNothingStops(*reading.config), "");
}

TEST(ExecConfig, NeedsNoMoreThanOneState) {
  const Parsed<ExecConfig> reading = Read("[state.SetUp]\nstart = [\"server\"]\n");
  ASSERT_TRUE(reading.config);
  ExecConfig expected = ConfigForProgram({"server"});
  expected.file = "audio.toml";
  EXPECT_EQ(*reading.config, expected);
}

TEST(ExecConfig, WarnsOfWhatNoEmergencyStopStops) {
  const std::string none = "/robot/audio.toml:1:1: warning: audio.toml has no [emergency_stop]: ";
  musher::testing::ExpectDiagnostics(
      Read,
      {{"a program",
        "[state.SetUp]\nstart = [\"server\"]\n",
        {none + "nothing stops its program; `musher estop` does not confirm its stop"}},
       {"a command of Active",
        "[state.Active]\nrun = [\"true\"]\n",
        {none + "nothing stops what its commands switch on; `musher estop` does not"}},
       {"commands that switch nothing on",
        "[state.SetUp]\nrun = [\"true\"]\n[state.SelfCheck]\nrun = [\"true\"]\n"
        "[state.Active]\n",
        {}},
       {"a stop", "[state.Active]\nrun = [\"true\"]\n[emergency_stop]\nshell = \"true\"\n", {}}});
}

TEST(ExecConfig, ReportsWhatIsWrongAndWhere) {
  musher::testing::ExpectDiagnostics(
      Read,
      {{"a state that the state config does not list",
        "[state.Activ]\nrun = [\"true\"]\n",
        {"/robot/audio.toml:1:8: error: state.Activ: the state config does not list this state for "
         "audio; it lists SetUp, TearDown, SelfCheck and Active; did you mean \"Active\"?"}},
       {"a shell line in place of arguments",
        "[state.Active]\nrun = \"echo hello\"\n",
        {"/robot/audio.toml:2:7: error: state.Active.run: expected an array of strings, found a "
         "string; write [\"program\", \"argument\"], or shell = \"echo hello\" for a shell line"}},
       {"a start in another state than SetUp",
        "[state.Active]\nstart = [\"server\"]\n",
        {"2:9: error: state.Active.start: a program that keeps running is started in SetUp"}},
       {"both run and shell",
        "[state.Active]\nrun = [\"true\"]\nshell = \"true\"\n",
        {"3:9: error: state.Active.shell: expected either run or shell, found both"}},
       {"all errors at once",
        "modul = 1\nstop_ms = 0\n[state.Active]\nrun = []\nruns = [\"\"]\n"
        "[state.SetUp]\nrun = [\"\"]\n",
        {":1:1: error: unknown key \"modul\"; did you mean \"module\"?",
         ":2:11: error: stop_ms: expected an integer from 1",
         ":4:7: error: state.Active.run: expected at least one string",
         ":5:1: error: state.Active: unknown key \"runs\"",
         ":7:8: error: state.SetUp.run: expected a program"}},
       {"an emergency stop that does nothing",
        "[state.Active]\n[emergency_stop]\n",
        {":2:1: error: emergency_stop: expected run, shell or end_program = true"}},
       {"an end of no program",
        "[state.Active]\n[emergency_stop]\nend_program = true\n",
        {":3:15: error: emergency_stop.end_program: [state.SetUp] starts no program"}},
       {"all errors of an emergency stop",
        "[state.Active]\n[emergency_stop]\nrun = [\"true\"]\nshell = \"true\"\ntime_ms = 0\n"
        "start = [\"server\"]\n",
        {":4:9: error: emergency_stop.shell: expected either run or shell, found both",
         ":5:11: error: emergency_stop.time_ms: expected an integer from 1",
         ":6:1: error: emergency_stop: unknown key \"start\""}},
       {"no state", "module = 100\n", {"the key \"state\" is missing"}},
       {"no table of states", "state = 3\n", {"expected a table, found an integer"}},
       {"no table of a state",
        "[state]\nActive = 3\n",
        {"2:10: error: state.Active: expected a table, found"}},
       {"no TOML", "module = \n", {"/robot/audio.toml:1:"}}});
}

TEST(ExecConfig, ReportsWhyAFileCannotBeRead) {
  const Parsed<ExecConfig> missing = ReadExecFile("/nowhere/at/all.toml", Audio());
  ASSERT_EQ(missing.diagnostics.size(), 1U);
  EXPECT_THAT(missing.diagnostics.front().message, HasSubstr("No such file"));
  const Parsed<ExecConfig> folder = ReadExecFile("/", Audio());
  ASSERT_EQ(folder.diagnostics.size(), 1U);
  EXPECT_THAT(folder.diagnostics.front().message, HasSubstr("it is a folder"));
}

TEST(CyberdogConfig, HasAGoodExecFileForEachActuator) {
  const std::string folder = SourceDir() + "/config/";
  const ConfigReading machine = ReadConfigFile(folder + "cyberdog.toml");
  ASSERT_TRUE(machine.config);
  EXPECT_THAT(machine.diagnostics, IsEmpty());
  ASSERT_EQ(machine.config->actuators.size(), 7U);
  for (const ActuatorConfig& actuator : machine.config->actuators) {
    const Parsed<ExecConfig> reading =
        ReadExecFile(folder + "exec/" + actuator.name + ".toml", actuator);
    EXPECT_TRUE(reading.config) << actuator.name;
    EXPECT_THAT(reading.diagnostics, IsEmpty()) << actuator.name;
    EXPECT_THAT(actuator.command, ElementsAre("musher-exec", actuator.name + ".toml"));
  }
}

}  // namespace musher::exec::exec_config_test
