// musher prove: configs that are proved, that are not, and those in which it finds a scenario.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "musher/base/files.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/nightly.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::prove_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// `legs` are critical; the states of `lamp` and more of its keys, and of legs.
std::string Robot(const std::string& states_of_lamp, const std::string& of_lamp,
                  const std::string& of_legs = "") {
  return R"([controller]
actuators = ["legs", "lamp"]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "Protected", "DeActive"]
default_time = 1000
default_state = "Uninitialized"

[actuator.legs]
states = ["SetUp", "TearDown", "SelfCheck", "Active", "Protected", "DeActive"]
times = [1000, 1000, 1000, 1000, 1000, 1000]
command = ["legs"]
critical = true
)" + of_legs +
         R"(
[actuator.lamp]
states = [)" +
         states_of_lamp + "]\ncommand = [\"lamp\"]\n" + of_lamp;
}

constexpr const char* kAllStates =
    R"("SetUp", "TearDown", "SelfCheck", "Active", "Protected", "DeActive")";
constexpr const char* kSixTimes = "times = [1000, 1000, 1000, 1000, 1000, 1000]\n";

class Proving : public ::testing::Test {
 protected:
  Proving() { setenv("XDG_CACHE_HOME", (folder_ / "cache").c_str(), 1); }
  ~Proving() override { unsetenv("XDG_CACHE_HOME"); }

  std::string Config(const std::string& text) const {
    std::ofstream(folder_ / "robot.toml") << text;
    return folder_ / "robot.toml";
  }
  std::string Valid() const {
    return Config(Robot(kAllStates, std::string(kSixTimes) + "on_lost = \"Active\"\n"));
  }
  // Where legs are lost, which are not restarted, lamp cannot follow to Protected.
  std::string WithoutFallback() const {
    return Config(Robot(R"("SetUp", "TearDown", "SelfCheck", "Active", "DeActive")",
                        "times = [1000, 1000, 1000, 1000, 1000]\non_lost = \"Active\"\n",
                        "restart = \"no\"\n"));
  }

  // The proof from DeActive, ended by its budget once a search has finished.
  Ran Interrupted(const std::string& file) const {
    for (double budget_s = 0.5;; budget_s *= 2) {
      Ran ran = RunProgram({"prove", file, "--from", "DeActive", "--faults", "9", "--budget",
                            std::to_string(budget_s), "--json"});
      EXPECT_EQ(ran.exit, 5) << ran.out << ran.err;
      const auto json = nlohmann::json::parse(ran.out);
      for (const auto& search : json["searches"]) {
        if (search["complete"] == true) return ran;
      }
      if (HasFailure()) return ran;
    }
  }
  // Continues it up to no fault; how many searches are those of the earlier run.
  int Resume(const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {
        "prove",   folder_ / "robot.toml", "--from", "DeActive", "--faults", "0", "--json",
        "--resume"};
    words.insert(words.end(), more.begin(), more.end());
    resumed_ = RunProgram(words);
    EXPECT_EQ(resumed_.exit, 0) << resumed_.out << resumed_.err;
    const auto json = nlohmann::json::parse(resumed_.out);
    int earlier = 0;
    for (const auto& search : json["searches"]) earlier += search["earlier_run"] == true ? 1 : 0;
    return earlier;
  }

  TempFolder folder_;
  Ran resumed_;
};

TEST_F(Proving, AValidRobotIsProvedForOneFault) {
  const Ran ran = RunProgram({"prove", Valid()});
  EXPECT_EQ(ran.exit, 0) << ran.out;
  EXPECT_THAT(ran.out, AllOf(HasSubstr("2 actuators, 5 states, up to 1 fault"),
                             HasSubstr("Proved for 1 fault: "), HasSubstr(" transitions, in ")));
}

TEST_F(Proving, TheJsonHasEverySearchAndTheResult) {
  const Ran ran = RunProgram({"prove", Valid(), "--from", "DeActive", "--json"});
  EXPECT_EQ(ran.exit, 0) << ran.out;
  const auto json = nlohmann::json::parse(ran.out);
  EXPECT_EQ(json["result"], "proved");
  EXPECT_EQ(json["proved_faults"], 1);
  EXPECT_EQ(json["from"], "DeActive");
  EXPECT_TRUE(json["rules"].is_null());
  EXPECT_TRUE(json["rule_coverage"].is_null());
  EXPECT_THAT(json["left_out"].dump(), HasSubstr("another machine (--other-machine"));
  EXPECT_EQ(json["left_out"].size(), 1U);
  EXPECT_TRUE(json["counter_example"].is_null());
  EXPECT_GE(json["searches"].size(), 8U);
  for (const auto& search : json["searches"]) EXPECT_EQ(search["from"], "DeActive");
}

TEST_F(Proving, AFallbackThatAnActuatorDoesNotListIsShownAsATimeline) {
  const std::string svg = folder_ / "found.svg";
  const Ran ran = RunProgram({"prove", WithoutFallback(), "--faults", "9", "--svg", svg});
  EXPECT_EQ(ran.exit, 1) << ran.out;
  EXPECT_THAT(ran.out, AllOf(HasSubstr("The shortest counter-example, from Active to "),
                             HasSubstr("⚡ "), HasSubstr("✗ lamp stays in Active"),
                             HasSubstr("Protected is not among the states of lamp")));
  EXPECT_THAT(ReadFile(svg), AllOf(HasSubstr("<svg"), HasSubstr(">lamp</text>")));
}

// The words of the command that replays the counter-example of `json`.
std::vector<std::string> ReplayOf(const std::string& config, const nlohmann::json& json) {
  const auto& example = json["counter_example"];
  std::vector<std::string> words = {"prove",    config,
                                    "--faults", std::to_string(example["faults"].get<int>()),
                                    "--replay", example["replay"].get<std::string>()};
  if (example["from"].is_null()) return words;
  words.insert(words.end(), {"--from", example["from"].get<std::string>(), "--to",
                             example["to"].get<std::string>()});
  return words;
}

TEST_F(Proving, TheCommandItPrintsReplaysTheCounterExample) {
  const std::string file = WithoutFallback();
  const Ran ran = RunProgram({"prove", file, "--json"});
  ASSERT_EQ(ran.exit, 1) << ran.out;
  const auto json = nlohmann::json::parse(ran.out);
  const std::vector<std::string> words = ReplayOf(file, json);
  const Ran replayed = RunProgram(words);
  EXPECT_EQ(replayed.exit, 1) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, AllOf(HasSubstr(json["counter_example"]["text"].get<std::string>()),
                                  HasSubstr("This scenario violates a rule.")));
  std::vector<std::string> as_json = words;
  as_json.emplace_back("--json");
  const auto again = nlohmann::json::parse(RunProgram(as_json).out);
  EXPECT_EQ(again["violations"], json["counter_example"]["violations"]);
  // With several threads another scenario of the same length may be found.
  EXPECT_THAT(RunProgram({"prove", file}).out,
              ::testing::ContainsRegex("Replay it: musher prove [^ ]+ --from [A-Za-z]+ --to "
                                       "[A-Za-z]+ --faults 1 --replay [0-9.]+\n"));
}

// What has been fixed does not violate a rule in that scenario, if it still has it.
TEST_F(Proving, AScenarioOfTheConfigBeforeItsFixViolatesNoRule) {
  const std::string faulty = WithoutFallback();
  const auto json = nlohmann::json::parse(RunProgram({"prove", faulty, "--json"}).out);
  const Ran ran = RunProgram(ReplayOf(Valid(), json));
  EXPECT_NE(ran.exit, 1) << ran.out;
  if (ran.exit == 2) {
    EXPECT_THAT(ran.err, HasSubstr("of another config"));
  }
}

TEST_F(Proving, AScenarioThatDoesNotExistIsAWrongCommandLine) {
  const std::string file = Valid();
  const auto error_of = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"prove", file});
    const Ran ran = RunProgram(words);
    EXPECT_EQ(ran.exit, 2) << ran.out;
    return ran.err;
  };
  for (const char* path : {"0.x", "0..1", ".1", "1.", "12345", "-1", "0.99999999999999999999"}) {
    EXPECT_THAT(error_of({"--replay=" + std::string(path)}), HasSubstr("is not the path")) << path;
  }
  EXPECT_THAT(error_of({"--from", "Active", "--to", "DeActive", "--replay", "0.999"}),
              HasSubstr("event 2 of this scenario is not possible here"));
  EXPECT_THAT(error_of({"--from", "Active", "--to", "DeActive", "--replay", "0"}),
              HasSubstr("its path is not whole"));
  EXPECT_THAT(error_of({"--from", "Active", "--replay", "0"}), HasSubstr("needs --from and --to"));
  EXPECT_THAT(error_of({"--from", "Active", "--to", "DeActve", "--replay", "0"}),
              HasSubstr("did you mean 'DeActive'?"));
  EXPECT_THAT(error_of({"--to", "DeActive"}), HasSubstr("--replay"));
}

TEST_F(Proving, ACounterExampleIsShownAlsoWhereItCannotBeDrawn) {
  const Ran ran = RunProgram({"prove", WithoutFallback(), "--svg", folder_ / "none/found.svg"});
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.out, AllOf(HasSubstr("✗ lamp stays in Active"), HasSubstr("Violated")));
  EXPECT_THAT(ran.err, HasSubstr("--svg: can't write " + folder_ / "none/found.svg"));
}

TEST_F(Proving, AStateThatNothingLeadsToIsNotProved) {
  const Ran ran = RunProgram(
      {"prove",
       Config(Robot(kAllStates, std::string(kSixTimes)) + "on_lost = \"Active\"\n[[transition]]\n"
                                                          "from = \"Active\"\nto = \"DeActive\"\n"),
       "--from", "Protected"});
  EXPECT_EQ(ran.exit, 5) << ran.err;
  EXPECT_THAT(ran.out, AllOf(HasSubstr("Not finished: no sequence of requests without a fault "
                                       "leads to Protected; nothing is proved"),
                             Not(HasSubstr("Proved"))));
}

TEST_F(Proving, WhatIsLeftOutOfTheConfigIsNamed) {
  const std::string file = Config(Robot(kAllStates, std::string(kSixTimes)) +
                                  "on_lost = \"Active\"\ncheckpoint_ms = 500\n"
                                  "[safety]\npermit_ms = 300\n");
  const Ran ran = RunProgram({"prove", file, "--faults", "0"});
  EXPECT_EQ(ran.exit, 0) << ran.out << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("not searched: [safety] permit_ms; messages of"));
  const Ran json = RunProgram({"prove", file, "--faults", "0", "--json"});
  EXPECT_EQ(nlohmann::json::parse(json.out)["left_out"].size(), 2U) << json.out;
}

TEST_F(Proving, ARobotOfTwoComputersIsProvedWhereItsLinkIsCut) {
  std::string text = ReadFile(SourceDir() + "/examples/two_computers/robot.toml");
  const Ran ran = RunProgram({"prove", Config(text), "--from", "Active"});
  EXPECT_EQ(ran.exit, 0) << ran.out << ran.err;
  const std::size_t line = text.find("on_lost = \"Active\"");
  ASSERT_NE(line, std::string::npos);
  text.erase(line, text.find('\n', line) - line);
  const Ran without = RunProgram({"prove", Config(text), "--from", "Active"});
  EXPECT_EQ(without.exit, 1) << without.out << without.err;
  EXPECT_THAT(without.out, AllOf(HasSubstr("the controller notices that host vision is out of"),
                                 HasSubstr("eyes has no on_lost")));
}

TEST_F(Proving, MessagesOfAnotherMachineAreFaultsWhereTheyAreToBeSearched) {
  const std::vector<std::string> words = {"prove", Valid(), "--from", "DeActive", "--json"};
  std::vector<std::string> with = words;
  with.emplace_back("--other-machine");
  const Ran ran = RunProgram(with);
  EXPECT_EQ(ran.exit, 0) << ran.out << ran.err;
  const auto json = nlohmann::json::parse(ran.out);
  EXPECT_EQ(json["result"], "proved");
  EXPECT_TRUE(json["left_out"].empty()) << json["left_out"];
  const auto without = nlohmann::json::parse(RunProgram(words).out);
  EXPECT_GT(json["transitions"], without["transitions"]);
}

// Its path counts the events of another machine.
TEST_F(Proving, TheCommandThatReplaysNamesTheOtherMachineToo) {
  const Ran ran = RunProgram({"prove", WithoutFallback(), "--other-machine"});
  EXPECT_EQ(ran.exit, 1) << ran.out << ran.err;
  EXPECT_THAT(ran.out, ::testing::ContainsRegex("Replay it: musher prove [^ ]+ --other-machine "
                                                "--from [A-Za-z]+ --to [A-Za-z]+ --faults 1 "));
}

// As if by Ctrl-C: the signal waits for the program to take it.
Ran RunInterrupted(const std::vector<std::string>& words) {
  sigset_t interrupt;
  sigset_t before;
  sigemptyset(&interrupt);
  sigaddset(&interrupt, SIGINT);
  pthread_sigmask(SIG_BLOCK, &interrupt, &before);
  raise(SIGINT);
  Ran ran = RunProgram(words);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  EXPECT_EQ(ran.exit, 130) << ran.out;
  return ran;
}

TEST_F(Proving, WhatIsProvedIsSaidWhereItIsInterrupted) {
  const Ran ran = RunInterrupted({"prove", Valid(), "--faults", "9"});
  EXPECT_THAT(ran.out,
              AllOf(HasSubstr("Not finished: it was interrupted; "), Not(HasSubstr("--resume"))));
}

TEST_F(Proving, AnInterruptedProofIsContinuedByTheCommandThatItPrints) {
  const std::string file = Valid();
  const auto interrupted = nlohmann::json::parse(Interrupted(file).out);
  EXPECT_EQ(interrupted["resume"], "musher prove " + file + " --from DeActive --faults 9 --resume");
  const std::vector<std::string> words = {"prove", file, "--from", "DeActive", "--faults", "0"};
  std::vector<std::string> as_json = words;
  as_json.emplace_back("--json");
  const auto fresh = nlohmann::json::parse(RunProgram(as_json).out);
  EXPECT_GT(Resume(), 0);
  const auto resumed = nlohmann::json::parse(resumed_.out);
  EXPECT_EQ(resumed["result"], "proved");
  EXPECT_TRUE(resumed["resume"].is_null());
  EXPECT_EQ(resumed["states"], fresh["states"]);
  EXPECT_EQ(resumed["transitions"], fresh["transitions"]);
  EXPECT_EQ(resumed["searches"].size(), fresh["searches"].size());
}

// The file also has the searches from other states.
TEST_F(Proving, AProofThatIsInterruptedAtOnceCountsOnlyTheSearchesThatItCanUse) {
  const std::string file = Valid();
  Interrupted(file);
  const auto from = [&file](const std::string& state) {
    const Ran ran =
        RunInterrupted({"prove", file, "--from", state, "--faults", "9", "--resume", "--json"});
    return nlohmann::json::parse(ran.out)["resume"];
  };
  EXPECT_TRUE(from("Active").is_null());
  EXPECT_FALSE(from("DeActive").is_null());
}

TEST_F(Proving, TheTextNamesTheCommandThatContinues) {
  const std::string file = Valid();
  Interrupted(file);
  std::string text;
  for (int budget_s = 1; text.find("Continue: ") == std::string::npos && budget_s < 100;) {
    text = RunProgram({"prove", file, "--from", "DeActive", "--faults", "9", "--resume", "--budget",
                       std::to_string(budget_s *= 2)})
               .out;
  }
  EXPECT_THAT(text, AllOf(HasSubstr("made by an earlier run"),
                          HasSubstr("kept. Continue: musher prove " + file +
                                    " --from DeActive --faults 9 --resume\n")));
}

TEST_F(Proving, WhatAnotherConfigOrOtherRulesHaveKeptDoesNotCount) {
  const std::string file = Valid();
  Interrupted(file);
  const std::string none =
      "--resume: no finished searches of this config, its rules and this build "
      "of Musher are kept; all searches are made";
  std::ofstream(folder_ / "rules.txt") << "never lamp Active while legs is exited\n";
  EXPECT_EQ(Resume({"--rules", folder_ / "rules.txt"}), 0);
  EXPECT_THAT(resumed_.err, HasSubstr(none));
  EXPECT_EQ(Resume({"--other-machine"}), 0);
  EXPECT_THAT(resumed_.err, HasSubstr(none));
  std::ofstream(file, std::ios::app) << "# changed\n";
  EXPECT_EQ(Resume(), 0);
  EXPECT_THAT(resumed_.err, HasSubstr(none));
}

TEST_F(Proving, ADamagedFileOfFinishedSearchesIsNamedAndAllIsSearchedAgain) {
  Interrupted(Valid());
  const auto kept = EntriesOf(folder_ / "cache/musher/prove");
  ASSERT_EQ(kept.size(), 1U);
  std::ofstream(kept.front(), std::ios::app) << "x";
  EXPECT_EQ(Resume(), 0);
  EXPECT_THAT(resumed_.err,
              HasSubstr(kept.front().string() + ": it is damaged; all searches are made\n"));
}

TEST_F(Proving, SearchesThatCannotBeKeptAreSaid) {
  const std::string file = Valid();
  setenv("XDG_CACHE_HOME", file.c_str(), 1);  // which is no folder
  const Ran ran = Interrupted(file);
  EXPECT_TRUE(nlohmann::json::parse(ran.out)["resume"].is_null());
  EXPECT_THAT(ran.err, HasSubstr("finished searches are not kept: can't make the folder "));
}

TEST_F(Proving, ABudgetThatIsUsedUpSaysWhatIsProved) {
  const Ran ran = RunProgram({"prove", Valid(), "--faults", "9", "--budget", "0.001"});
  EXPECT_EQ(ran.exit, 5) << ran.out;
  EXPECT_THAT(ran.out, AllOf(HasSubstr("Not finished: its budget of 0.001 s is used up"),
                             Not(HasSubstr("Proved"))));
}

// What is complete, with how many faults, and what is not.
TEST_F(Proving, ABudgetThatIsUsedUpSaysWhichSearchesAreNotComplete) {
  const std::string file = Valid();
  for (double budget_s = 1;; budget_s *= 2) {
    const Ran ran = RunProgram({"prove", file, "--faults", "9", "--from", "DeActive", "--budget",
                                std::to_string(budget_s)});
    ASSERT_EQ(ran.exit, 5) << ran.out;
    if (ran.out.find("proved without a fault") == std::string::npos &&
        ran.out.find("proved for ") == std::string::npos) {
      continue;
    }
    EXPECT_THAT(ran.out, ::testing::ContainsRegex("not complete, with [0-9]+ faults?: from "
                                                  "DeActive to [A-Z][a-zA-Z]*"));
    break;
  }
}

TEST_F(Proving, MemoryThatIsUsedUpEndsIt) {
  const Ran ran = RunProgram({"prove", Valid(), "--faults", "9", "--memory", "0.001"});
  EXPECT_EQ(ran.exit, 5) << ran.out;
  EXPECT_THAT(ran.out, HasSubstr("it has used 0.001 GB of memory (--memory permits more)"));
}

TEST_F(Proving, ARuleOfItsUserIsChecked) {
  std::ofstream(folder_ / "rules.txt") << "never lamp Active while legs is exited\n";
  const std::string rules = folder_ / "rules.txt";
  const Ran ran = RunProgram({"prove", Valid(), "--rules", rules, "--from", "Active"});
  EXPECT_EQ(ran.exit, 0) << ran.out;
  EXPECT_THAT(ran.out, HasSubstr("1 rule of your own"));
  std::ofstream(folder_ / "rules.txt") << "never lamp Protected while legs is Protected\n";
  const Ran bad = RunProgram({"prove", Valid(), "--rules", rules, "--from", "Active"});
  EXPECT_EQ(bad.exit, 1) << bad.out;
  EXPECT_THAT(bad.out, HasSubstr("✗ your rule: never lamp Protected while legs is Protected"));
}

TEST_F(Proving, TheRulesThatTheConfigNamesAreChecked) {
  const std::string file =
      Config(Robot(kAllStates, std::string(kSixTimes) + "on_lost = \"Active\"\n") +
             "[safety]\nrules = \"rules.txt\"\n");
  std::ofstream(folder_ / "rules.txt") << "never lamp Protected while legs is Protected\n";
  const Ran bad = RunProgram({"prove", file, "--from", "Active"});
  EXPECT_EQ(bad.exit, 1) << bad.out << bad.err;
  EXPECT_THAT(bad.out, AllOf(HasSubstr("✗ your rule: never lamp Protected while legs is Protected"),
                             Not(HasSubstr("--rules"))));
  std::ofstream(folder_ / "others.txt") << "never lamp Active while legs is exited\n";
  const Ran others =
      RunProgram({"prove", file, "--from", "Active", "--rules", folder_ / "others.txt"});
  EXPECT_EQ(others.exit, 0) << others.out;
}

// That it holds says nothing then: without a fault legs are never exited in a stable state.
TEST_F(Proving, ARuleWhoseConditionIsNeverReachedIsNamed) {
  const std::string rules = folder_ / "rules.txt";
  std::ofstream(rules) << "never lamp Active while legs is exited\n"
                          "never lamp Protected while legs is not Protected\nnever lamp SetUp\n";
  const std::vector<std::string> words = {"prove",  Valid(),  "--rules",  rules,
                                          "--from", "Active", "--faults", "0"};
  const Ran ran = RunProgram(words);
  EXPECT_EQ(ran.exit, 0) << ran.out;
  EXPECT_THAT(ran.out,
              AllOf(HasSubstr("  UNTESTED  never lamp Active while legs is exited: its condition "
                              "holds in none of "),
                    HasSubstr("  rule      never lamp Protected while legs is not Protected: its "
                              "condition holds in "),
                    HasSubstr("  rule      never lamp SetUp: lamp is in SetUp in 0 of ")));
  std::vector<std::string> as_json = words;
  as_json.emplace_back("--json");
  const auto coverage = nlohmann::json::parse(RunProgram(as_json).out)["rule_coverage"];
  ASSERT_EQ(coverage.size(), 3U);
  EXPECT_EQ(coverage[0]["tested"], false);
  EXPECT_EQ(coverage[0]["condition"], 0);
  EXPECT_GT(coverage[0]["stable_states"], 0);
  EXPECT_EQ(coverage[1]["tested"], true);
  EXPECT_GT(coverage[1]["condition"], 0);
  EXPECT_GT(coverage[1]["forbidden"], 0) << "lamp was in Protected, beside legs in Protected";
  EXPECT_EQ(coverage[2]["tested"], true);
  EXPECT_TRUE(coverage[2]["condition"].is_null());
  EXPECT_EQ(coverage[2]["forbidden"], 0);
}

// Legs and lamp switch at the same time, in 1 s at most.
TEST_F(Proving, ARuleWithATimeIsProved) {
  const std::string rules = folder_ / "rules.txt";
  std::ofstream(rules) << "never lamp Active while legs is exited\n"
                          "within 1 s of DeActive lamp in DeActive\n";
  const std::vector<std::string> words = {"prove",  Valid(),  "--rules",  rules,
                                          "--from", "Active", "--faults", "0"};
  const Ran ran = RunProgram(words);
  EXPECT_EQ(ran.exit, 0) << ran.out << ran.err;
  EXPECT_THAT(ran.out, AllOf(HasSubstr("2 rules of your own"), Not(HasSubstr("rules with a time")),
                             HasSubstr("  rule      within 1 s of DeActive lamp in DeActive: its "
                                       "time begins ")));
  std::vector<std::string> as_json = words;
  as_json.emplace_back("--json");
  const auto json = nlohmann::json::parse(RunProgram(as_json).out);
  EXPECT_EQ(json["rules"], 2);
  ASSERT_EQ(json["rule_coverage"].size(), 2U);
  EXPECT_GT(json["rule_coverage"][1]["begun"], 0);
  EXPECT_GT(json["rule_coverage"][1]["met"], 0);
}

TEST_F(Proving, ARuleWithATimeThatTheConfigNamesIsViolatedByACallbackThatTakesAllOfIts) {
  std::ofstream(folder_ / "rules.txt") << "within 0.5 s of DeActive lamp in DeActive\n";
  const std::string file =
      Config(Robot(kAllStates, std::string(kSixTimes) + "on_lost = \"Active\"\n") +
             "[safety]\nrules = \"rules.txt\"\n");
  const Ran ran = RunProgram({"prove", file, "--from", "Active", "--faults", "0"});
  EXPECT_EQ(ran.exit, 1) << ran.out << ran.err;
  EXPECT_THAT(ran.out, AllOf(HasSubstr("The shortest counter-example, from Active to DeActive"),
                             HasSubstr("almost 1000 ms pass"),
                             HasSubstr("✗ your rule: within 0.5 s of DeActive lamp in DeActive")));
}

// With a fault such times are sampled by `musher simulate`.
TEST_F(Proving, TimesBetweenNoneAndAllAreSaidToBeLeftOutOfRulesWithATime) {
  const std::string rules = folder_ / "rules.txt";
  std::ofstream(rules) << "within 60 s of DeActive lamp in DeActive or exited\n";
  const Ran ran = RunProgram({"prove", Valid(), "--rules", rules, "--from", "Protected"});
  EXPECT_THAT(ran.out, HasSubstr("not searched: for rules with a time, with a fault: callbacks "
                                 "that take some of their time"));
}

TEST_F(Proving, AWrongRuleIsReportedWithItsPlace) {
  std::ofstream(folder_ / "rules.txt") << "\nnever lmp Active\n";
  const std::string rules = folder_ / "rules.txt";
  const Ran ran = RunProgram({"prove", Valid(), "--rules", rules});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, AllOf(HasSubstr("rules.txt:2:7: error: "), HasSubstr("lamp")));
}

// A regular file, which gives an error when it is read.
TEST_F(Proving, RulesThatCannotBeReadAreAnError) {
  for (const char* command : {"prove", "simulate"}) {
    for (const char* file : {"/proc/self/mem", "/nonexistent", "/"}) {
      const Ran ran = RunProgram({command, Valid(), "--rules", file});
      EXPECT_EQ(ran.exit, 2) << ran.out;
      EXPECT_THAT(ran.err, HasSubstr(std::string("--rules ") + file + ": the file cannot be read"));
    }
  }
}

TEST_F(Proving, AnUnknownStateIsAWrongCommandLine) {
  const Ran ran = RunProgram({"prove", Valid(), "--from", "DeActiv"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("did you mean 'DeActive'?"));
}

// --- the configs that are shipped ---

// With a sanitizer the search is ten times slower, and finds other errors anyway.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kFew = true;
#else
constexpr bool kFew = false;
#endif

// By the time that their search takes.
std::vector<std::string> AllShipped() {
  return {"cyberdog2", "wedding", "programs", "meilin", "robot", "cyberdog", "race", "skills"};
}

// The gate has the first one alone.
std::vector<std::string> Shipped() {
  if (kFew || !testing::Nightly()) return {AllShipped().front()};
  return AllShipped();
}

// The result of a proof of the config, as JSON; prints its figures.
nlohmann::json Proved(const std::string& name, const std::vector<std::string>& options) {
  static const TempFolder cache;
  setenv("XDG_CACHE_HOME", cache.path().c_str(), 1);
  std::vector<std::string> words = {"prove", SourceDir() + "/config/" + name + ".toml", "--json"};
  words.insert(words.end(), options.begin(), options.end());
  const Ran ran = RunProgram(words);
  EXPECT_TRUE(ran.exit == 0 || ran.exit == 1 || ran.exit == 5) << name << ran.err;
  auto json = nlohmann::json::parse(ran.out, nullptr, false);
  if (!json.is_object()) return nlohmann::json::object();
  std::cout << "| " << name << " | up to " << json["faults"] << " | " << json["result"] << " | "
            << json["states"] << " states | " << json["transitions"] << " transitions | "
            << json["took_s"] << " s |\n";
  const auto& found = json["counter_example"];
  if (found.is_object()) std::cout << found["text"].get<std::string>() << "\n";
  return json;
}

TEST(ShippedConfigs, AreAllProved) {
  std::vector<std::string> names;
  for (const auto& path : EntriesOf(SourceDir() + "/config")) {
    if (path.extension() == ".toml") names.push_back(path.stem());
  }
  EXPECT_THAT(AllShipped(), ::testing::UnorderedElementsAreArray(names));
}

TEST(ShippedConfigs, AreProvedWithoutAFault) {
  for (const std::string& name : Shipped()) {
    auto json = Proved(name, {"--faults", "0"});
    EXPECT_EQ(json["result"], "proved") << name << ": " << json["why"];
  }
}

// The larger ones are not finished then. A suite, and so a time limit, of its own.
TEST(ShippedConfigsWithOneFault, ViolateNoRuleWithinTheBudget) {
  if (!testing::Nightly() || kFew) GTEST_SKIP() << "only in the nightly run";
  for (const std::string& name : Shipped()) {
    auto json = Proved(name, {"--budget", "90"});
    EXPECT_TRUE(json["result"] == "proved" || json["result"] == "not finished") << name;
    if (name == AllShipped().front()) {
      EXPECT_EQ(json["proved_faults"], 1);
    }
  }
}

}  // namespace musher::cli::prove_test
