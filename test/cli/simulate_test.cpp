// musher simulate: valid configs, and configs with a planted flaw.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "musher/base/files.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/nightly.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::simulate_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// legs are critical; the voice is restarted, or given up.
std::string Robot(const std::string& of_the_voice, const std::string& more = "") {
  return R"([controller]
actuators = ["legs", "voice"]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "Protected", "DeActive", "LowPower", "OTA", "Error"]
default_time = 1000
default_state = "Uninitialized"

[actuator.legs]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "Protected", "DeActive", "LowPower", "OTA", "Error"]
times = [1000, 1000, 1000, 1000, 1000, 1000, 1000, 1000, 1000]
command = ["legs"]
critical = true

[actuator.voice]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "Protected", "DeActive", "LowPower", "OTA", "Error"]
times = [1000, 1000, 1000, 1000, 1000, 1000, 1000, 1000, 1000]
command = ["voice"]
restart_limit = 2
restart_prevent_exit_codes = []
)" + of_the_voice +
         "\n" + more;
}

// The gate's find what is planted, too.
const std::string kFew = testing::Nightly() ? "100" : "40";
const std::string kSeeds = testing::Nightly() ? "300" : "200";

constexpr const char* kProvided = "on_lost = \"Active\"";

class Simulating : public ::testing::Test {
 protected:
  std::string Config(const std::string& text) const {
    std::ofstream(folder_ / "robot.toml") << text;
    return folder_ / "robot.toml";
  }
  std::string Read(const std::string& file) const {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  TempFolder folder_;
};

TEST_F(Simulating, AValidRobotPassesEveryScenario) {
  const Ran ran = RunProgram({"simulate", Config(Robot(kProvided)), "--seeds", kFew});
  EXPECT_EQ(ran.exit, 0) << ran.out;
  EXPECT_THAT(ran.out,
              AllOf(HasSubstr("2 actuators, " + kFew + " scenarios"), Not(HasSubstr("VIOLATED")),
                    HasSubstr("controller-crash"), HasSubstr("All scenarios passed.")));
}

// No manager is simulated.
TEST_F(Simulating, ARobotThatAManagerStartsIsStartedByItsController) {
  const Ran ran = RunProgram(
      {"simulate", Config(Robot(kProvided, "[ros2]\nstart = \"manager\"\n")), "--seeds", kFew});
  EXPECT_EQ(ran.exit, 0) << ran.out;
  EXPECT_THAT(ran.out,
              AllOf(HasSubstr("2 actuators, " + kFew + " scenarios"), Not(HasSubstr("VIOLATED")),
                    HasSubstr("controller-crash"), HasSubstr("All scenarios passed.")));
}

TEST_F(Simulating, EveryShippedConfigIsValid) {
  int configs = 0;
  for (const auto& path : EntriesOf(SourceDir() + "/config")) {
    if (path.extension() != ".toml") continue;
    ++configs;
    const Ran ran = RunProgram({"check", path.string()});
    EXPECT_EQ(ran.exit, 0) << path << ran.out << ran.err;
  }
  EXPECT_GE(configs, 7);
}

TEST_F(Simulating, TheShippedConfigsPassEveryScenario) {
  for (const char* name : {"robot.toml", "wedding.toml", "cyberdog.toml", "programs.toml"}) {
    const Ran ran = RunProgram({"simulate", SourceDir() + "/config/" + name, "--seeds",
                                testing::Nightly() ? "300" : "12"});
    EXPECT_EQ(ran.exit, 0) << ran.out;
  }
}

TEST_F(Simulating, ARestartLimitWithoutOnLostIsFoundAndShrunkToTheFewestCrashes) {
  const std::string config = Config(Robot(""));
  const Ran ran = RunProgram({"simulate", config, "--seeds", kSeeds, "--json"});
  EXPECT_EQ(ran.exit, 1);
  const auto json = nlohmann::json::parse(ran.out);
  EXPECT_FALSE(json["passed"]);
  const auto& scenario = json["shortest_failing_scenario"];
  EXPECT_THAT(scenario["text"].get<std::string>(),
              AllOf(HasSubstr("⚡"), HasSubstr("without voice, which"),
                    HasSubstr("it has no on_lost (\"Active\" if the machine may run without it)")));
  EXPECT_LE(scenario["only"].size(), 3U);  // no more than the crashes that two restarts take
}

TEST_F(Simulating, AWrongConfigWithoutOnLostIsFoundAndTakesOneInjection) {
  std::string robot = Robot("");
  const std::string key = "restart_prevent_exit_codes = []\n";
  robot.erase(robot.find(key), key.size());
  const Ran ran = RunProgram({"simulate", Config(robot), "--seeds", kSeeds, "--json"});
  EXPECT_EQ(ran.exit, 1);
  const auto scenario = nlohmann::json::parse(ran.out)["shortest_failing_scenario"];
  EXPECT_THAT(scenario["text"].get<std::string>(),
              AllOf(HasSubstr("the configuration of voice is wrong"),
                    HasSubstr("without voice, which is not restarted after its exit code")));
  EXPECT_EQ(scenario["only"].size(), 1U);
}

TEST_F(Simulating, AFlowWithNoTransitionBackFromOtaIsFoundAndDrawn) {
  const std::string config = Config(Robot(kProvided, R"(
[[transition]]
from = ["Active", "Protected", "DeActive", "LowPower"]
to = ["Active", "Protected", "DeActive", "LowPower", "OTA"]
)"));
  const std::string svg = folder_ / "scenario.svg";
  const Ran ran = RunProgram({"simulate", config, "--seeds", kFew, "--svg", svg});
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.out, HasSubstr("the machine is in OTA, from where no switch leads to Active"));
  EXPECT_THAT(Read(svg), AllOf(StartsWith("<svg"), HasSubstr("the operator requests OTA"),
                               HasSubstr("from where no switch leads to Active")));
}

// A fallback to a less active state ignores the flow.
TEST_F(Simulating, AFlowThatForbidsTheFallbackToOnLostIsNoViolation) {
  const std::string config = Config(Robot(kProvided, R"(
[[transition]]
from = ["Active", "LowPower", "Protected", "OTA", "DeActive"]
to = ["Active", "LowPower"]
)"));
  const Ran ran = RunProgram({"simulate", config, "--seeds", kFew});
  EXPECT_THAT(ran.out, Not(HasSubstr("without legs, whose on_lost is Protected")));
}

// The battery falls in the same step in which the switch back up ends: what it has lowered then may
// be raised again.
TEST_F(Simulating, ALoweringThatBeginsAsARaiseEndsIsRememberedByTheCheck) {
  const Ran ran = RunProgram(
      {"simulate", SourceDir() + "/config/robot.toml", "--seed", "1135", "--only", "2,6,8,9"});
  EXPECT_EQ(ran.exit, 0) << ran.out;
}

TEST_F(Simulating, TheCommandItPrintsReplaysTheSameScenario) {
  const std::string config = Config(Robot(""));
  const auto report =
      nlohmann::json::parse(RunProgram({"simulate", config, "--seeds", kSeeds, "--json"}).out);
  const auto& scenario = report["shortest_failing_scenario"];
  std::string only;
  for (const auto& number : scenario["only"]) {
    only += (only.empty() ? "" : ",") + std::to_string(number.get<int>());
  }
  const Ran replayed = RunProgram(
      {"simulate", config, "--seed", std::to_string(scenario["seed"].get<int>()), "--only", only});
  EXPECT_EQ(replayed.exit, 1);
  EXPECT_THAT(replayed.out, StartsWith(scenario["text"].get<std::string>()));
}

TEST_F(Simulating, InvalidInputIsReportedAndNothingIsSimulated) {
  const std::string config = Config(Robot(kProvided));
  const auto error_of = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"simulate", config});
    const Ran ran = RunProgram(arguments);
    EXPECT_EQ(ran.exit, 2);
    EXPECT_EQ(ran.out, "");
    return ran.err;
  };
  EXPECT_THAT(error_of({"--seeds", "0"}), HasSubstr("--seeds"));
  EXPECT_THAT(error_of({"--seeds", "many"}), HasSubstr("--seeds"));
  EXPECT_THAT(error_of({"--only", "3"}), HasSubstr("--only requires --seed"));
  EXPECT_THAT(error_of({"--seed", "1", "--only", "3,x"}),
              HasSubstr("'3,x' is not a list of numbers"));
  EXPECT_THAT(error_of({"--seed", "1", "--only", "99"}), HasSubstr("and no 99"));
  EXPECT_THAT(error_of({"--home", "Actve"}), HasSubstr("did you mean 'Active'?"));
  EXPECT_THAT(error_of({"--bound", "-1"}), HasSubstr("--bound"));
}

TEST_F(Simulating, ARuleOfItsUserIsChecked) {
  const std::string rules = folder_ / "rules.txt";
  std::ofstream(rules) << "never voice Active while machine is Active\n";
  const std::string config = Config(Robot(kProvided));
  const Ran ran = RunProgram({"simulate", config, "--seeds", kFew, "--rules", rules});
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.out, AllOf(HasSubstr("VIOLATED  your own rules hold (1 rule)"),
                             HasSubstr("✗ never voice Active while machine is Active")));
  std::ofstream(rules) << "never voice Active while machine is Error\n";
  const Ran good = RunProgram({"simulate", config, "--seeds", kFew, "--rules", rules});
  EXPECT_EQ(good.exit, 0) << good.out;
  EXPECT_THAT(good.out, HasSubstr("holds     your own rules hold (1 rule)"));
}

TEST_F(Simulating, ARuleWhoseConditionIsNeverReachedIsNamed) {
  const std::string rules = folder_ / "rules.txt";
  // Once it is torn down nothing is checked: the machine is never stable in TearDown.
  std::ofstream(rules) << "never voice Active while machine is TearDown\n"
                          "never voice SetUp while voice is Active\n";
  const std::string config = Config(Robot(kProvided));
  const std::vector<std::string> words = {"simulate", config, "--seeds", kFew, "--rules", rules};
  const Ran ran = RunProgram(words);
  EXPECT_EQ(ran.exit, 0) << ran.out;
  EXPECT_THAT(ran.out,
              AllOf(HasSubstr("  UNTESTED  never voice Active while machine is TearDown: its "
                              "condition holds in none of "),
                    HasSubstr("  rule      never voice SetUp while voice is Active: its "
                              "condition holds in ")));
  std::vector<std::string> as_json = words;
  as_json.emplace_back("--json");
  const auto coverage = nlohmann::json::parse(RunProgram(as_json).out)["rule_coverage"];
  ASSERT_EQ(coverage.size(), 2U);
  EXPECT_EQ(coverage[0]["tested"], false);
  EXPECT_EQ(coverage[0]["condition"], 0);
  EXPECT_GT(coverage[0]["stable_states"], 0);
  EXPECT_EQ(coverage[1]["tested"], true);
  EXPECT_GT(coverage[1]["condition"], 0);
  EXPECT_GE(coverage[1]["stable_states"], coverage[1]["condition"]);
}

TEST_F(Simulating, ARuleWithATimeIsChecked) {
  const std::string rules = folder_ / "rules.txt";
  std::ofstream(rules) << "within 1 ms of Active voice in Active\n";
  const std::string config = Config(Robot(kProvided));
  const Ran bad = RunProgram({"simulate", config, "--seeds", kFew, "--rules", rules});
  EXPECT_EQ(bad.exit, 1);
  EXPECT_THAT(bad.out, AllOf(HasSubstr("VIOLATED  your own rules hold (1 rule)"),
                             HasSubstr("✗ within 1 ms of Active voice in Active")));
  // No run is so long.
  std::ofstream(rules) << "within 1440 min of Active voice in Active\n";
  const std::vector<std::string> words = {"simulate", config, "--seeds", kFew, "--rules", rules};
  const Ran good = RunProgram(words);
  EXPECT_EQ(good.exit, 0) << good.out;
  EXPECT_THAT(good.out, HasSubstr("  rule      within 1440 min of Active voice in Active: its "
                                  "time begins "));
  std::vector<std::string> as_json = words;
  as_json.emplace_back("--json");
  const auto coverage = nlohmann::json::parse(RunProgram(as_json).out)["rule_coverage"];
  ASSERT_EQ(coverage.size(), 1U);
  EXPECT_EQ(coverage[0]["tested"], true);
  EXPECT_GT(coverage[0]["begun"], 0);
  EXPECT_GT(coverage[0]["met"], 0);
  EXPECT_TRUE(coverage[0]["stable_states"].is_null());
}

TEST_F(Simulating, TheRulesThatTheConfigNamesAreChecked) {
  std::ofstream(folder_ / "rules.txt") << "never voice Active while machine is Active\n";
  const std::string config = Config(Robot(kProvided) + "\n[safety]\nrules = \"rules.txt\"\n");
  const Ran ran = RunProgram({"simulate", config, "--seeds", kFew});
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.out, AllOf(HasSubstr("VIOLATED  your own rules hold (1 rule)"),
                             Not(HasSubstr("--rules"))));
}

}  // namespace musher::cli::simulate_test
