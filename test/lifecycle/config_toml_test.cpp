// Reading of valid state configs. The messages for invalid ones are in test/golden.

#include "musher/lifecycle/config/config_toml.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "musher/lifecycle/config/flow.hpp"

namespace musher::config_toml_test {

using ::testing::HasSubstr;

const std::string kController = R"(
[controller]
actuators = ["wheels", "voice"]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "Protected", "LowPower", "Error"]
default_time = 250
default_state = "Uninitialized"
)";

const std::string kWheels = R"(
[actuator.wheels]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "Protected", "LowPower", "Error"]
times = [8000, 4000, 3000, 2000, 1000, 900, 800]
)";

const std::string kVoice = R"(
[actuator.voice]
states = ["SetUp", "TearDown", "SelfCheck", "Active"]
times = [1, 2, 3, 4]
)";

// Reads a config that must be valid.
MachineConfig Read(const std::string& text, const std::string& path = "/robots/sled.toml") {
  ConfigReading reading = ReadConfigText(text, path);
  for (const Diagnostic& diagnostic : reading.diagnostics) {
    EXPECT_NE(diagnostic.severity, Severity::kError) << FormatDiagnostic(diagnostic);
  }
  return reading.config.value_or(MachineConfig{});
}

MachineConfig ReadWith(const std::string& wheels_keys) {
  return Read(kController + kVoice + kWheels + wheels_keys);
}

// Sets an environment variable for the length of a test.
class ScopedEnvironment {
 public:
  ScopedEnvironment(const char* name, const char* value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    Set(value);
  }
  ~ScopedEnvironment() { Set(old_ ? old_->c_str() : nullptr); }
  ScopedEnvironment(const ScopedEnvironment&) = delete;
  ScopedEnvironment& operator=(const ScopedEnvironment&) = delete;

 private:
  void Set(const char* value) { value != nullptr ? setenv(name_, value, 1) : unsetenv(name_); }

  const char* name_;
  std::optional<std::string> old_;
};

TEST(ConfigToml, ReadsTheKeysThatCyberDogHas) {
  const MachineConfig config = Read(kController + kVoice + kWheels);
  EXPECT_EQ(config.states.size(), 7U);
  EXPECT_EQ(config.default_time, Milliseconds(250));
  EXPECT_EQ(config.default_state, "Uninitialized");
  ASSERT_EQ(config.actuators.size(), 2U);
  EXPECT_EQ(config.actuators[1].states,
            (std::vector<State>{"SetUp", "TearDown", "SelfCheck", "Active"}));
  EXPECT_EQ(config.TimeFor(0, "LowPower"), Milliseconds(900));
  EXPECT_EQ(config.TimeFor(1, "LowPower"), Milliseconds(250));
}

TEST(ConfigToml, KeepsTheOrderOfTheControllersList) {
  const MachineConfig config = Read(kController + kVoice + kWheels);
  EXPECT_EQ(config.actuators[0].name, "wheels");
  EXPECT_EQ(config.actuators[1].name, "voice");
}

TEST(ConfigToml, AddsTearDownToAMachineThatDoesNotListIt) {
  std::string text = kController + kVoice + kWheels;
  for (const std::string word : {"\"TearDown\", ", "4000, ", "2, "}) {
    for (std::size_t at = 0; (at = text.find(word)) != std::string::npos;) {
      text.erase(at, word.size());
    }
  }
  const MachineConfig config = Read(text);
  EXPECT_TRUE(config.HasState("TearDown"));
  EXPECT_TRUE(FlowAllows(config, "Active", "TearDown"));
  EXPECT_FALSE(config.actuators[0].Lists("TearDown"));
}

TEST(ConfigToml, GivesTheDocumentedDefaults) {
  const MachineConfig config = Read(kController + kVoice + kWheels);
  EXPECT_EQ(config.name, "sled");
  EXPECT_EQ(config.file, "/robots/sled.toml");
  EXPECT_EQ(config.name_space, "");
  EXPECT_EQ(config.shutdown_budget, Milliseconds(10'000));
  EXPECT_EQ(config.log, "");
  EXPECT_EQ(config.transport, TransportProfile::kLocal);
  EXPECT_EQ(config.flow, DefaultFlow(config.states));
  const ActuatorConfig& wheels = config.actuators[0];
  EXPECT_TRUE(wheels.command.empty());
  EXPECT_EQ(wheels.protocol, Protocol::kMusher);
  EXPECT_EQ(wheels.stage, 1);
  EXPECT_FALSE(wheels.critical);
  EXPECT_EQ(wheels.restart, RestartConfig{});
  EXPECT_EQ(wheels.checkpoint, std::nullopt);
  EXPECT_EQ(wheels.on_lost, "");
}

TEST(ConfigToml, RestartsOnFailureWhatItStartsItself) {
  EXPECT_EQ(ReadWith("command = [\"wheels\"]").actuators[0].restart.policy,
            RestartPolicy::kOnFailure);
  EXPECT_EQ(ReadWith("").actuators[0].restart.policy, RestartPolicy::kNo);
  EXPECT_EQ(ReadWith("command = [\"wheels\"]\nrestart = \"no\"").actuators[0].restart.policy,
            RestartPolicy::kNo);
}

TEST(ConfigToml, PreventsRestartsAfterExitCodeTwoUnlessOtherCodesAreNamed) {
  const auto codes = [](const std::string& keys) {
    return ReadWith("command = [\"wheels\"]\n" + keys).actuators[0].restart.prevent_exit_codes;
  };
  EXPECT_EQ(codes(""), std::vector<int>{2});
  EXPECT_EQ(codes("restart_prevent_exit_codes = [3, 255]"), (std::vector<int>{3, 255}));
  EXPECT_EQ(codes("restart_prevent_exit_codes = []"), std::vector<int>{});
}

TEST(ConfigToml, ProtectsTheMachineWhenACriticalActuatorIsLost) {
  EXPECT_EQ(ReadWith("critical = true").actuators[0].on_lost, "Protected");
  EXPECT_FALSE(ReadWith("critical = true").actuators[0].critical_codes);
  EXPECT_EQ(ReadWith("critical_codes = [1409, 1509]").actuators[0].critical_codes,
            (std::vector<std::int32_t>{1409, 1509}));
  EXPECT_EQ(ReadWith("critical_codes = []").actuators[0].critical_codes,
            (std::vector<std::int32_t>{}));
  EXPECT_EQ(ReadWith("critical = true\non_lost = \"Error\"").actuators[0].on_lost, "Error");
}

TEST(ConfigToml, FallsToTheHighestListedStateUpToProtectedWithoutAController) {
  const MachineConfig config = Read(kController + kVoice + kWheels);
  EXPECT_EQ(config.actuators[0].on_controller_lost, "Protected");
  EXPECT_EQ(config.actuators[1].on_controller_lost, "TearDown");
}

TEST(ConfigToml, ReadsThePageOfTheMachine) {
  EXPECT_EQ(ReadWith("").view, std::nullopt);
  EXPECT_EQ(ReadWith("[view]\n").view, ViewConfig());
  const ViewConfig view =
      *ReadWith(
           "[view]\nport = 80\nbind = \"::\"\ntoken_file = \"token\"\nhosts = [\"dog.local\"]\n")
           .view;
  EXPECT_EQ(view, (ViewConfig{80, "::", "/robots/token", {"dog.local"}}));
}

TEST(ConfigToml, SeesPathsFromTheConfigsFolder) {
  const MachineConfig config =
      ReadWith("command = [\"../bin/wheels\", \"a/b\"]\ncwd = \"run\"\nenv = { A = \"x/y\" }");
  const ActuatorConfig& wheels = config.actuators[0];
  EXPECT_EQ(wheels.command, (std::vector<std::string>{"/bin/wheels", "a/b"}));
  EXPECT_EQ(wheels.cwd, "/robots/run");
  EXPECT_EQ(wheels.env.at("A"), "x/y");
}

TEST(ConfigToml, LeavesBareAndAbsoluteProgramsAlone) {
  EXPECT_EQ(ReadWith("command = [\"wheels\"]").actuators[0].command[0], "wheels");
  EXPECT_EQ(ReadWith("command = [\"/opt/wheels\"]").actuators[0].command[0], "/opt/wheels");
}

TEST(ConfigToml, KeepsRepeatedAndEmptyArguments) {
  EXPECT_EQ(ReadWith("command = [\"w\", \"-v\", \"-v\", \"\"]").actuators[0].command,
            (std::vector<std::string>{"w", "-v", "-v", ""}));
}

TEST(ConfigToml, PutsStateBelowTheUsersStateFolder) {
  const ScopedEnvironment domain("ROS_DOMAIN_ID", nullptr);
  const ScopedEnvironment xdg("XDG_STATE_HOME", "/var/state");
  EXPECT_EQ(Read(kController + kVoice + kWheels).state_dir, "/var/state/musher/sled");
}

TEST(ConfigToml, PutsStateBelowTheHomeWhereTheEnvironmentNamesNoStateFolder) {
  const ScopedEnvironment domain("ROS_DOMAIN_ID", nullptr);
  const ScopedEnvironment home("HOME", "/home/driver");
  const ScopedEnvironment xdg("XDG_STATE_HOME", "relative/is/ignored");
  EXPECT_EQ(Read(kController + kVoice + kWheels).state_dir,
            "/home/driver/.local/state/musher/sled");
}

TEST(ConfigToml, PutsStateBelowVarLibWhereThereIsNoHome) {
  const ScopedEnvironment domain("ROS_DOMAIN_ID", nullptr);
  const ScopedEnvironment home("HOME", nullptr);
  const ScopedEnvironment xdg("XDG_STATE_HOME", nullptr);
  EXPECT_EQ(Read(kController + kVoice + kWheels).state_dir, "/var/lib/musher/sled");
}

TEST(ConfigToml, GivesRobotsOfOneHostAStateFolderEach) {
  const ScopedEnvironment xdg("XDG_STATE_HOME", "/var/state");
  const std::string fleet = kController + "namespace = \"fleet/sled_3\"\n" + kVoice + kWheels;
  {
    const ScopedEnvironment domain("ROS_DOMAIN_ID", "0");
    EXPECT_EQ(Read(fleet).state_dir, "/var/state/musher/sled@fleet.sled_3");
  }
  const ScopedEnvironment domain("ROS_DOMAIN_ID", "7");
  EXPECT_EQ(Read(fleet).state_dir, "/var/state/musher/sled@fleet.sled_3.domain7");
  EXPECT_EQ(Read(kController + kVoice + kWheels).state_dir, "/var/state/musher/sled.domain7");
}

TEST(ConfigToml, FindsTheFileOfTheRulesBesideTheConfig) {
  const std::string robot = kController + kVoice + kWheels;
  EXPECT_EQ(Read(robot).rules_file, "");
  EXPECT_EQ(Read(robot + "[safety]\nrules = \"rules.txt\"\n").rules_file, "/robots/rules.txt");
  EXPECT_EQ(Read(robot + "[safety]\nrules = \"/etc/rules.txt\"\n").rules_file, "/etc/rules.txt");
}

// The text alone is read: a journal has it on another computer, where that file is not.
TEST(ConfigToml, IsValidWhereTheFileOfTheRulesIsNot) {
  const MachineConfig config =
      Read(kController + kVoice + kWheels + "[safety]\nrules = \"rules.txt\"\n");
  const UserRulesReading read = ReadRulesOf(config);
  ASSERT_EQ(read.diagnostics.size(), 1U);
  EXPECT_EQ(FormatDiagnostic(read.diagnostics[0]),
            "/robots/sled.toml: error: safety.rules: /robots/rules.txt: the file cannot be read: "
            "No such file or directory");
}

class FileOfRules : public ::testing::Test {
 protected:
  // What is wrong with the rules of a config that names this file.
  std::string Fault() const {
    const MachineConfig config =
        Read(kController + kVoice + kWheels + "[safety]\nrules = \"" + file_ + "\"\n");
    const UserRulesReading read = ReadRulesOf(config);
    return read.diagnostics.empty() ? "" : read.diagnostics[0].message;
  }

  const std::string file_ = ::testing::TempDir() + "rules_" + std::to_string(getpid()) + ".txt";
};

TEST_F(FileOfRules, ThatWouldBlockIsNotOpened) {
  ASSERT_EQ(mkfifo(file_.c_str(), 0600), 0);
  EXPECT_THAT(Fault(), HasSubstr("it is a FIFO"));
  std::remove(file_.c_str());
}

TEST_F(FileOfRules, HasAThousandAtMost) {
  const auto write = [this](int rules) {
    std::ofstream file(file_);
    for (int i = 0; i < rules; ++i) file << "never machine Error\n";
  };
  write(1000);
  EXPECT_EQ(Fault(), "");
  write(1001);
  EXPECT_EQ(Fault(), "1001 rules; at most 1000");
  std::remove(file_.c_str());
}

TEST(ConfigToml, ReadsTheMachinesOwnKeys) {
  const MachineConfig config = Read(kController + R"(name = "sled_3"
namespace = "/fleet/sled_3"
state_dir = "state/."
log = "logs/sled.log"
log_group = "robots"
shutdown_budget_ms = 1
journal_size_mb = 2
log_size_mb = 3
logs_size_mb = 4
)" + kVoice + kWheels + "[transport]\nprofile = \"lan\"");
  EXPECT_EQ(config.name, "sled_3");
  EXPECT_EQ(config.name_space, "fleet/sled_3");
  EXPECT_EQ(config.state_dir, "/robots/state");
  EXPECT_EQ(config.log, "/robots/logs/sled.log");
  EXPECT_EQ(config.log_group, "robots");
  EXPECT_EQ(config.shutdown_budget, Milliseconds(1));
  EXPECT_EQ(config.journal_size_bytes, 2 << 20);
  EXPECT_EQ(config.log_size_bytes, 3 << 20);
  EXPECT_EQ(config.logs_size_bytes, 4 << 20);
  EXPECT_EQ(config.actuators[0].log_size_bytes, 3 << 20) << "an actuator's, unless it has its own";
  EXPECT_EQ(config.transport, TransportProfile::kLan);
}

TEST(ConfigToml, MakesANameOfTheFilesStem) {
  const std::string text = kController + kVoice + kWheels;
  EXPECT_EQ(Read(text, "/a/my-sled.v2.toml").name, "my_sled_v2");
  EXPECT_EQ(Read(text, "3dogs.toml").name, "_3dogs");
}

TEST(ConfigToml, RanksOwnStates) {
  const MachineConfig config = Read(R"(
state = [{ name = "Parked", rank = 3 }]
[controller]
actuators = ["a"]
states = ["SetUp", "Active", "Parked"]
default_time = 250
[actuator.a]
states = ["SetUp", "Parked"]
times = [1, 2]
)");
  EXPECT_EQ(config.RankOf("Parked"), 3);
  EXPECT_EQ(config.RankOf("Active"), 6);
  EXPECT_EQ(config.RankOf("SetUp"), std::nullopt);
  EXPECT_EQ(config.actuators[0].on_controller_lost, "Parked");
  EXPECT_EQ(config.flow, DefaultFlow(config.states));
}

TEST(ConfigToml, ReplacesTheFlowByTheFilesTransitions) {
  const MachineConfig config = Read(kController + kVoice + kWheels + R"(
[[transition]]
from = "Active"
to = ["LowPower", "Protected"]
[[transition]]
from = "Error"
to = "SelfCheck"
)");
  const std::vector<FlowEdge> expected = {
      {"Active", "Protected"}, {"Active", "LowPower"}, {"Error", "SelfCheck"}};
  EXPECT_EQ(config.flow, expected);
}

TEST(ConfigToml, TakesAStarForEveryStableStateThatCanBeLeft) {
  const MachineConfig config =
      Read(kController + kVoice + kWheels + "[[transition]]\nfrom = \"*\"\nto = \"Error\"");
  const std::vector<FlowEdge> expected = {
      {"Active", "Error"}, {"Protected", "Error"}, {"LowPower", "Error"}};
  EXPECT_EQ(config.flow, expected);
}

TEST(ConfigToml, HashesTheBytesOfTheFile) {
  const std::string text = kController + kVoice + kWheels;
  const std::string hash = Read(text).hash;
  EXPECT_EQ(hash.size(), 16U);
  EXPECT_EQ(Read(text, "/elsewhere/x.toml").hash, hash);
  EXPECT_NE(Read(text + "#").hash, hash);
}

TEST(ConfigToml, AcceptsAByteOrderMarkAndCarriageReturns) {
  const std::string plain = kController + kVoice + kWheels;
  std::string text = "\xEF\xBB\xBF";
  for (const char c : plain) {
    if (c == '\n') text += '\r';
    text += c;
  }
  EXPECT_EQ(Read(text).actuators.size(), 2U);
}

TEST(ConfigToml, ReadsFromAFileWhatItReadsFromItsText) {
  const std::filesystem::path path = std::filesystem::path(::testing::TempDir()) / "sled.toml";
  std::ofstream(path) << kController + kVoice + kWheels;
  const ConfigReading reading = ReadConfigFile(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(reading.config);
  EXPECT_EQ(*reading.config, Read(kController + kVoice + kWheels, path));
}

TEST(ReadValidConfig, GivesTheConfigOfAValidFile) {
  const std::filesystem::path path = std::filesystem::path(::testing::TempDir()) / "valid.toml";
  std::ofstream(path) << kController + kVoice + kWheels;
  const Result<MachineConfig> config = ReadValidConfig(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(config.ok()) << config.error().message;
  EXPECT_EQ(config.value().name, "valid");
}

// Found by ConfigTomlProperty: the parser shows a broken word with the end of its line.
TEST(ConfigToml, ReportsABrokenWordOnOneLine) {
  const ConfigReading reading = ReadConfigText("[policy]\nmanager = t\r\n", "robot.toml");
  ASSERT_EQ(reading.diagnostics.size(), 1U);
  EXPECT_EQ(reading.diagnostics.front().message.find_first_of("\r\n"), std::string::npos)
      << reading.diagnostics.front().message;
}

TEST(ReadValidConfig, IsAnErrorWhereNoFileIsNamedAtAll) {
  EXPECT_EQ(ReadValidConfig("").error().code, kCodeParametersInvalid);
}

TEST(ReadValidConfig, ReportsAllErrorsAndNoWarnings) {
  const std::filesystem::path path = std::filesystem::path(::testing::TempDir()) / "faulty.toml";
  std::ofstream(path) << kController + kVoice + kWheels + "restart = \"no\"\nstage = 0\nx = 1\n";
  const Result<MachineConfig> config = ReadValidConfig(path);
  std::filesystem::remove(path);
  ASSERT_FALSE(config.ok());
  const std::string& message = config.error().message;
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 1);
  EXPECT_NE(message.find(":16:9: error: actuator.wheels.stage"), std::string::npos) << message;
  EXPECT_EQ(message.find("warning"), std::string::npos) << message;
}

TEST(ConfigFile, HasKeysInAFolderBesideItOrNone) {
  EXPECT_EQ(ReadWith("").keys, "");
  EXPECT_EQ(ReadWith("[security]\nkeys = \"keys\"\n").keys, "/robots/keys");
  EXPECT_EQ(ReadWith("[security]\nkeys = \"/etc/musher/keys\"\n").keys, "/etc/musher/keys");
}

TEST(ConfigToml, ReadsWhatTheRobotCanDoAndWhere) {
  const MachineConfig config = ReadWith(
      "[capability.roll]\ndescription = \"on its wheels\"\nactuators = [\"wheels\"]\n"
      "states = [\"Active\", \"Protected\"]\n"
      "[capability.race]\nactuators = [\"wheels\", \"voice\"]\nmin_battery = 40\n");
  ASSERT_EQ(config.capabilities.size(), 2U);
  EXPECT_EQ(config.capabilities[0],
            (CapabilityConfig{
                "roll", "on its wheels", {"wheels"}, {"Active", "Protected"}, std::nullopt}));
  EXPECT_EQ(config.capabilities[1],
            (CapabilityConfig{"race", "", {"wheels", "voice"}, {"Active"}, 40}))
      << "without states it runs in Active only";
  EXPECT_EQ(config.CapabilityOf("race"), &config.capabilities[1]);
  EXPECT_EQ(config.CapabilityOf("fly"), nullptr);
}

// As an actuator, whose controller has checked them.
TEST(ConfigToml, WithoutAManagerSkipsTheTablesOfOneButNoOtherKey) {
  const MachineConfig config = ReadWith("[policy.low_power]\n[policy.voice]\nsay = 5\n");
  EXPECT_EQ(config.policy->manager_policy.get(), nullptr);
  EXPECT_EQ(config.policy->unread_keys, std::vector<std::string>{"policy.voice"});
  EXPECT_TRUE(config.policy->low_power->motion_ids.empty());
  for (const std::string policy : {"[policy]\nmangaer = true\n", "[policy.batery]\n"}) {
    const ConfigReading reading =
        ReadConfigText(kController + kVoice + kWheels + policy, "robot.toml");
    const auto is_refused = [](const Diagnostic& diagnostic) {
      return diagnostic.message.starts_with("policy: unknown key");
    };
    EXPECT_TRUE(std::any_of(reading.diagnostics.begin(), reading.diagnostics.end(), is_refused));
  }
}

}  // namespace musher::config_toml_test
