// `musher tree replay`.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>

#include "musher/base/files.hpp"
#include "musher/behavior/tree/build.hpp"
#include "musher/behavior/tree/recorder.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::tree_replay_test {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr const char* kNap = R"(<root BTCPP_format="4"><BehaviorTree ID="Nap">
  <Sequence>
    <Script code="naps := 1"/>
    <Sleep name="nap" msec="500"/>
  </Sequence>
</BehaviorTree></root>)";

class TreeReplayCommand : public ::testing::Test {
 protected:
  // Two trees, the first of which naps from 0 to 0.5 s.
  TreeReplayCommand() {
    tree::Recorder recorder([this](std::string_view lines) { text_ += lines; });
    recorder.Head("cat");
    Record(recorder, 1, 6);
    Record(recorder, 2, 2);
    Write(text_);
  }
  void Record(tree::Recorder& recorder, std::uint32_t revision, int ticks) {
    const tree::Factory factory;
    const tree::Document document = tree::ReadTree(kNap, "nap.xml").document;
    const auto tree = tree::Build(document, factory).tree;
    recorder.Begin({.tree = tree.get(),
                    .document = &document,
                    .factory = &factory,
                    .revision = revision,
                    .time = [](Time at) { return at.time_since_epoch(); }},
                   1'772'366'405'000'000);
    const std::shared_ptr<tree::Recorder> listener(&recorder, [](auto*) {});
    tree->Listen(listener);
    for (int i = 0; i < ticks; ++i) {
      const auto result = tree->TickOnce(Time(Milliseconds(100 * i)));
      recorder.Note({.at = Time(Milliseconds(100 * i)),
                     .wall_us = 1'772'366'405'000'000U + 100'000U * static_cast<unsigned>(i),
                     .ticking = true,
                     .result = result.value(),
                     .fault = revision == 2 && i == 1 ? "it broke" : ""});
    }
    recorder.End();
  }
  void Write(const std::string& text) const { std::ofstream(file_) << text; }
  Ran Replay(std::vector<std::string> more, bool json = false) const {
    std::vector<std::string> arguments = {"tree", "replay", file_};
    if (json) arguments.insert(arguments.begin(), "--json");
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunProgram(arguments);
  }

  const TempFolder folder_;
  const std::string file_ = folder_ / "cat.tree";
  std::string text_;
};

TEST_F(TreeReplayCommand, PrintsTheTransitionsAndTheTreeAtTheEnd) {
  setenv("TZ", "UTC", 1);
  const Ran ran = Replay({"--tree", "1"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_EQ(ran.out,
            "     0.000 s  Sequence/Script  IDLE -> SUCCESS\n"
            "     0.000 s  Sequence/nap  IDLE -> RUNNING\n"
            "     0.000 s  Sequence  IDLE -> RUNNING\n"
            "     0.000 s  ticking\n"
            "     0.500 s  Sequence/nap  RUNNING -> SUCCESS\n"
            "     0.500 s  Sequence  RUNNING -> SUCCESS\n"
            "\n"
            "cat  tree Nap  SUCCESS\n"
            "recorded, 0.500 of 0.500 s, tree 1 of 2, 2026-03-01 12:00:05.500\n"
            "NODE        TYPE   STATUS   RUNNING  RUNS\n"
            "✓ Sequence         SUCCESS  0.500 s  1\n"
            "  · Script         IDLE     0.000 s  1\n"
            "  · nap     Sleep  IDLE     0.500 s  1\n");
  EXPECT_THAT(Replay({}).out,
              AllOf(HasSubstr("tree 1 of 2"), HasSubstr("     0.100 s  fault: it broke\n"),
                    HasSubstr("last fault: it broke\n")));
}

TEST_F(TreeReplayCommand, ShowsTheTreeAsItWasAtATime) {
  const Ran ran = Replay({"--tree", "1", "--at", "0.3", "--entries", "--history", "1"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.out,
              AllOf(StartsWith("cat  tree Nap  RUNNING\nrecorded, 0.300 of 0.500 s"),
                    HasSubstr("▶ nap     Sleep  RUNNING  0.300 s  1\n"),
                    HasSubstr("0.000 s  Sequence  IDLE  RUNNING\n"),
                    Not(HasSubstr("Sequence/nap  IDLE")), HasSubstr("-      naps  number  1\n")));
  EXPECT_THAT(Replay({"--at", "99"}).out, HasSubstr("recorded, 0.100 of 0.100 s, tree 2 of 2"));
}

TEST_F(TreeReplayCommand, PrintsJson) {
  const Ran ran = Replay({"--at", "0.3", "--tree", "1"}, true);
  const auto json = nlohmann::json::parse(ran.out);
  EXPECT_EQ(json["actuator"], "cat");
  EXPECT_EQ(json["nodes"][2]["status"], "RUNNING");
  EXPECT_EQ(json["nodes"][2]["spent_s"], 0.3);
  EXPECT_EQ(json["wall_us"], 1'772'366'405'300'000);
  EXPECT_EQ(json["trees"], 2);
  EXPECT_TRUE(json["cut_at_line"].is_null());
  EXPECT_FALSE(json.contains("ticks"));
  std::istringstream lines(Replay({}, true).out);
  std::string line;
  std::vector<nlohmann::json> all;
  while (std::getline(lines, line)) all.push_back(nlohmann::json::parse(line));
  ASSERT_EQ(all.size(), 2U) << "a line for each tree";
  EXPECT_EQ(all[0]["history"].size(), 5U) << "all changes";
  EXPECT_EQ(all[1]["last_fault"], "it broke");
}

TEST_F(TreeReplayCommand, PlaysAtTheSpeedThatIsWanted) {
  const auto start = std::chrono::steady_clock::now();
  const Ran ran = Replay({"--tree", "1", "--speed", "2"});
  const auto took = std::chrono::steady_clock::now() - start;
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.out, EndsWith("     0.500 s  Sequence  RUNNING -> SUCCESS\n"));
  EXPECT_GE(took, std::chrono::milliseconds(250));
}

TEST_F(TreeReplayCommand, SaysWhichValuesOfAnOptionItTakes) {
  const Ran still = Replay({"--speed", "0"});
  EXPECT_EQ(still.exit, 2);
  EXPECT_THAT(still.err, HasSubstr("0 is not between 0.001 and 1000000 times its speed"));
  EXPECT_THAT(Replay({"--at", "-1"}).err, HasSubstr("-1 is not between 0 and 1000000000 seconds"));
  EXPECT_THAT(Replay({"--at", "nan"}).err, HasSubstr("nan is not between"));
  EXPECT_EQ(Replay({"--speed", "1", "--at", "1"}).exit, 2);
  EXPECT_EQ(Replay({"--btlog", folder_ / "cat.btlog", "--at", "1"}).exit, 2);
}

TEST_F(TreeReplayCommand, SaysThatTheRecordingOfALogEndsWithinALine) {
  Write(text_.substr(0, text_.rfind("change 0 0")) + "change 0 0 ID");
  const Ran ran = Replay({"--btlog", folder_ / "cat.btlog"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("everything before it is written"));
}

TEST_F(TreeReplayCommand, ShowsEverythingBeforeALossOfPowerAndSaysSo) {
  Write(text_.substr(0, text_.rfind("change 0 0")) + "change 0 0 ID");
  const Ran ran = Replay({"--tree", "2"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("Sequence/nap  IDLE -> RUNNING"));
  EXPECT_THAT(ran.err,
              AllOf(StartsWith("musher: " + file_ + ":"),
                    HasSubstr(": the recording ends within this line (a loss of power, or a "
                              "crash); everything before it is shown")));
  EXPECT_GT(nlohmann::json::parse(Replay({"--at", "0"}, true).out)["cut_at_line"], 10);
}

TEST_F(TreeReplayCommand, RefusesWhatIsDamagedOrNoRecording) {
  std::string damaged = text_;
  damaged[damaged.find("nap Sleep")] = 'm';
  Write(damaged);
  Ran ran = Replay({});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr(file_ + ":5:1: error: the line is damaged"));
  Write("<root/>\n");
  ran = Replay({});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr(":1:1: error: the recording of a tree begins with"));
  EXPECT_EQ(RunProgram({"tree", "replay", folder_ / "none"}).exit, 2);
  Write(text_.substr(0, text_.find('\n') + 1));
  EXPECT_THAT(Replay({}).err, HasSubstr("no tree was loaded so far"));
  Write(text_);
  EXPECT_THAT(Replay({"--tree", "3"}).err, HasSubstr("has 2 trees, no tree 3"));
}

TEST_F(TreeReplayCommand, WritesALogForGroot2) {
  const std::string out = folder_ / "cat.btlog";
  const Ran ran = Replay({"--tree", "1", "--btlog", out});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ReadFile(out), StartsWith("BTCPP4-FileLogger2\x01"));
  EXPECT_EQ(Replay({"--btlog", folder_ / "no/cat.btlog"}).exit, 2);
}

}  // namespace musher::cli::tree_replay_test
