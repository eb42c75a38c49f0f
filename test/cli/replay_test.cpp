// musher replay and musher history --why, on the journal of a robot that lost its legs.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "musher/test/cli/program.hpp"
#include "musher/test/controller/recorded_robot.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::replay_test {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::StartsWith;

class Replaying : public ::testing::Test {
 protected:
  Replaying() { Write(RecordedLife()); }

  void Write(const std::vector<JournalItem>& items) {
    Journal journal(file_, {});
    for (const JournalItem& item : items) journal.Append(item);
  }

  std::string Config(const std::string& text) const {
    std::ofstream(folder_ / "other.toml") << text;
    return folder_ / "other.toml";
  }

  TempFolder folder_;
  const std::string file_ = folder_ / "journal.sqlite";
};

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST_F(Replaying, RepeatsTheDecisionsAndReportsThatTheyAreEqual) {
  const Ran ran = RunProgram({"replay", file_});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_EQ(ran.err, "");
  EXPECT_THAT(ran.out, HasSubstr("machine  controller started: epoch 1, 3 actuators\n"));
  EXPECT_THAT(ran.out, HasSubstr("machine  an actuator is lost; falling back to Protected"));
  EXPECT_THAT(Lines(ran.out).back(),
              MatchesRegex("[0-9]+ inputs, [0-9]+ decisions: all as recorded"));
}

TEST_F(Replaying, ExitsWithOneWhenADecisionDiffers) {
  auto items = RecordedLife();
  for (JournalItem& item : items) {
    auto* entry = std::get_if<JournalEntry>(&item);
    if (entry != nullptr && entry->state == "Protected") entry->message = "all is well";
  }
  std::filesystem::remove(file_);
  Write(items);
  const Ran ran = RunProgram({"replay", file_});
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.out, ::testing::ContainsRegex("\n- [^\n]*  all is well "));
  EXPECT_THAT(ran.out, ::testing::ContainsRegex("\n\\+ [^\n]*  switch [0-9]+ is done"));
  EXPECT_THAT(ran.out, HasSubstr("    on {\"event\":\"Replied\","));
  EXPECT_THAT(ran.out, EndsWith(": 2 differences\n"));
}

TEST_F(Replaying, ShowsWhatAnotherConfigWouldChange) {
  const Ran ran = RunProgram({"replay", file_, "--config", Config(RobotToml("LowPower"))});
  EXPECT_EQ(ran.exit, 1) << ran.err;
  for (const std::string& line : Lines(ran.out)) EXPECT_THAT(line, Not(StartsWith("  20")));
  EXPECT_THAT(ran.out, ::testing::ContainsRegex("(^|\n)- [^\n]*falling back to Protected\n"));
  EXPECT_THAT(ran.out, ::testing::ContainsRegex("\n\\+ [^\n]*falling back to LowPower\n"));
  EXPECT_THAT(ran.out, HasSubstr("the machine ended in Protected, with the other config in "));
  const Ran same = RunProgram({"replay", file_, "--config", Config(RobotToml())});
  EXPECT_EQ(same.exit, 0);
}

TEST_F(Replaying, RefusesAConfigOfOtherActuators) {
  std::string text = RobotToml();
  for (std::size_t at = 0; (at = text.find("voice", at)) != std::string::npos;) {
    text.replace(at, 5, "tail");
  }
  const Ran ran = RunProgram({"replay", file_, "--config", Config(text)});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_EQ(ran.err, "musher: actuator 'tail' is not in the recorded config\n");
}

TEST_F(Replaying, FindsActuatorsByNameInAnotherOrder) {
  std::string text = RobotToml();
  const std::string list = R"(["legs", "eyes", "voice"])";
  text.replace(text.find(list), list.size(), R"(["voice", "legs", "eyes"])");
  const Ran ran = RunProgram({"replay", file_, "--config", Config(text)});
  EXPECT_EQ(ran.exit, 0) << ran.out;
}

TEST_F(Replaying, CanBeLimitedToAnEpoch) {
  const Ran ran = RunProgram({"replay", file_, "--epoch", "2"});
  EXPECT_EQ(ran.exit, 0);
  EXPECT_THAT(ran.out, Not(HasSubstr("controller started: epoch 1")));
  EXPECT_THAT(ran.out, HasSubstr("controller started: epoch 2"));
}

TEST_F(Replaying, AnswersInJson) {
  const Ran ran = RunProgram({"replay", file_, "--json"});
  EXPECT_EQ(ran.exit, 0);
  const auto json = nlohmann::json::parse(ran.out);
  EXPECT_EQ(json["equal"], true);
  EXPECT_EQ(json["differences"], 0);
  EXPECT_EQ(json["replayed_state"], "Protected");
  EXPECT_EQ(json["lines"].size(), json["decisions"]);
  EXPECT_TRUE(json["damage"].is_null());
}

TEST_F(Replaying, EndsWithTwoWithoutAJournal) {
  EXPECT_EQ(RunProgram({"replay", folder_ / "none"}).exit, 2);
  EXPECT_EQ(RunProgram({"replay"}).exit, 2);
  EXPECT_EQ(RunProgram({"replay", file_, "--since", "soon"}).exit, 2);
}

TEST_F(Replaying, ReportsWhatIsMissingInADamagedJournal) {
  std::filesystem::resize_file(file_, std::filesystem::file_size(file_) / 2);  // of both tables
  const Ran replay = RunProgram({"replay", file_});
  EXPECT_THAT(replay.err, ::testing::ContainsRegex("musher: read [0-9]+ entries and inputs; the "
                                                   "rest is damaged: "));
  EXPECT_NE(replay.exit, 1) << "what is missing is no difference";
  const Ran history = RunProgram({"history", "--journal", file_});
  EXPECT_THAT(history.err, ::testing::ContainsRegex("musher: read [0-9]+ entries; the rest is "
                                                    "damaged: "));
}

// The sentences behind "because", without times.
std::vector<std::string> Explained(const std::string& out) {
  std::vector<std::string> sentences;
  for (const std::string& line : Lines(out)) sentences.push_back(line.substr(25));
  return sentences;
}

TEST_F(Replaying, HistoryExplainsWhyTheMachineIsInItsState) {
  const Ran ran = RunProgram({"history", "--journal", file_, "--why"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(
      Explained(ran.out),
      ::testing::ElementsAre(
          MatchesRegex("the machine went to Protected \\(switch [0-9]+\\)"),
          "  because an actuator is lost; falling back to Protected",
          MatchesRegex("  because legs is degraded: crashed: its process 1001 ended.*NetError.*"),
          MatchesRegex("  because legs's process 1001 ended: exit code unknown.*")));
}

TEST_F(Replaying, HistoryExplainsARequestedState) {
  const Ran ran = RunProgram({"history", "--journal", file_, "--why", "LowPower"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(
      Explained(ran.out),
      ::testing::ElementsAre(MatchesRegex("the machine went to LowPower \\(switch [0-9]+\\)"),
                             "  because switch to LowPower requested"));
  const Ran none = RunProgram({"history", "--journal", file_, "--why", "OTA"});
  EXPECT_EQ(none.exit, 1);
  EXPECT_THAT(none.err, HasSubstr("these entries contain no change to OTA"));
  const auto json =
      nlohmann::json::parse(RunProgram({"history", "--journal", file_, "--why", "--json"}).out);
  EXPECT_EQ(json["state"], "Protected");
  EXPECT_EQ(json["chain"].size(), 4U);
  EXPECT_EQ(json["complete"], true);
}

TEST_F(Replaying, TimesAreLearnedFromTheJournal) {
  const std::string config = Config(RobotToml());
  const Ran ran = RunProgram({"times", config, "--journal", file_, "--json"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  const auto times = nlohmann::json::parse(ran.out)["times"];
  ASSERT_FALSE(times.empty());
  EXPECT_EQ(times[0]["actuator"], "eyes");
  EXPECT_GT(times[0]["missing_commands"], 0);
  EXPECT_TRUE(times[0]["proposed_ms"].is_null());
}

TEST_F(Replaying, TimesPrintsWhatChangesInTheConfig) {
  std::vector<std::string> words = {"times", Config(RobotToml()), "--journal", file_, "--diff"};
  const Ran none = RunProgram(words);
  EXPECT_EQ(none.exit, 0) << none.err;
  EXPECT_EQ(none.out, "");
  EXPECT_THAT(none.err, HasSubstr("no limit changes\n"));
  words.emplace_back("--least");
  words.emplace_back("1");
  const Ran ran = RunProgram(words);
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.out, StartsWith("--- "));
  EXPECT_THAT(ran.out, HasSubstr("other.toml\n+++ "));
  EXPECT_THAT(ran.out, HasSubstr("\n@@ -"));
  EXPECT_THAT(ran.out, HasSubstr("\n-times = ["));
  EXPECT_THAT(ran.out, HasSubstr("\n+times = ["));
  words.emplace_back("--json");
  EXPECT_EQ(nlohmann::json::parse(RunProgram(words).out)["diff"], ran.out);
}

// An unknown actuator gave an empty answer and exit code 0.
TEST_F(Replaying, HistoryOfAnUnknownActuatorIsAnError) {
  const Ran ran = RunProgram({"history", "--journal", file_, "--actuator", "lags"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("there is no actuator 'lags'; did you mean 'legs'?"));
  EXPECT_EQ(RunProgram({"history", "--journal", file_, "--actuator", "legs"}).exit, 0);
}

TEST_F(Replaying, HistoryOfLevelErrorContainsFailuresOnly) {
  const Ran ran = RunProgram({"history", "--journal", file_, "--level", "error", "--json"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  const auto entries = nlohmann::json::parse(ran.out)["entries"];
  EXPECT_FALSE(entries.empty());
  for (const auto& entry : entries) EXPECT_NE(entry["code"], 0);
}

TEST_F(Replaying, HistoryMarksACauseThatIsOlderThanItsFirstRecord) {
  const Ran ran = RunProgram({"history", "--journal", file_, "--why", "--lines", "5"});
  EXPECT_THAT(ran.out, EndsWith("    because of an event before these entries\n"));
}

}  // namespace musher::cli::replay_test
