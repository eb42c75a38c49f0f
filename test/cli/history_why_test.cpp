// musher history --why, on journals of a robot that runs for a night.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "musher/base/code.hpp"
#include "musher/controller/journal/journal.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::history_why_test {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kEvening = 1'780'000'000 * kSecond;

class HistoryWhy : public ::testing::Test {
 protected:
  // An entry one second after the last one.
  void Add(const std::string& actuator, const std::string& event, std::int32_t code,
           const std::string& message, const std::string& state = "") {
    JournalEntry entry;
    entry.wall_ns = kEvening + static_cast<std::int64_t>(entries_.size()) * kSecond;
    entry.epoch = epoch_;
    entry.kind = "switch";
    entry.actuator = actuator;
    entry.code = code;
    entry.message = message;
    entry.id = RecordId(next_id_++);
    entry.state = State(state);
    entry.event = event;
    entries_.push_back(entry);
  }
  void AddCrash(const std::string& actuator) {
    Add(actuator, "actuator_crashed", kCodeNetError, actuator + " crashed");
  }
  // The answer to `history --why` with these words.
  Ran Why(std::vector<std::string> words = {}) {
    {
      Journal journal(file_, {});
      for (const JournalEntry& entry : entries_) journal.Append(entry);
    }
    entries_.clear();
    words.insert(words.begin(), {"history", "--journal", file_, "--why"});
    return RunProgram(words);
  }

  TempFolder folder_;
  const std::string file_ = folder_ / "journal.sqlite";
  std::vector<JournalEntry> entries_;
  Epoch epoch_ = Epoch(1);
  std::uint64_t next_id_ = 1;  // each controller begins with 1
};

// It read the newest 1000 entries, and failed without a word about what they contained.
TEST_F(HistoryWhy, FindsTheChangeOfStateBeforeAThousandCrashes) {
  Add("", "machine_usable", 0, "the machine is Active", "Active");
  for (int i = 0; i < 1100; ++i) AddCrash("lidar");
  const Ran ran = Why();
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.out, AllOf(HasSubstr("last failure: lidar crashed"),
                             HasSubstr("the machine went to Active")));
}

TEST_F(HistoryWhy, NamesTheFailureWhereTheChangeOfStateIsOlderThanTheEntries) {
  Add("", "machine_usable", 0, "the machine is Active", "Active");
  AddCrash("lidar");
  const Ran ran = Why({"--lines", "1"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("last failure: lidar crashed"));
  EXPECT_THAT(ran.err, HasSubstr("the machine's last change of state is before these entries"));
  const auto json = nlohmann::json::parse(Why({"--lines", "1", "--json"}).out);
  EXPECT_TRUE(json["state"].is_null());
  EXPECT_THAT(json["chain"], IsEmpty());
  EXPECT_EQ(json["complete"], false);
  EXPECT_EQ(json["failure"][0]["message"], "lidar crashed");
}

// It was answered with the whole machine's failure and exit code 0.
TEST_F(HistoryWhy, OfAnActuatorIsItsLastFailure) {
  Add("", "machine_usable", 0, "the machine is Active", "Active");
  AddCrash("legs");
  AddCrash("lidar");
  const Ran legs = Why({"--actuator", "legs"});
  EXPECT_EQ(legs.exit, 0) << legs.err;
  EXPECT_THAT(legs.out, HasSubstr("last failure: legs crashed"));
  const Ran typo = Why({"--actuator", "lgs"});
  EXPECT_EQ(typo.exit, 2);
  EXPECT_THAT(typo.err, HasSubstr("there is no actuator 'lgs'; did you mean 'legs'?"));
}

TEST_F(HistoryWhy, OfAnActuatorWithoutAFailureSaysSo) {
  Add("legs", "command_done", 0, "legs: Active done");
  Add("", "machine_usable", 0, "the machine is Active", "Active");
  AddCrash("lidar");
  const Ran legs = Why({"--actuator", "legs"});
  EXPECT_EQ(legs.exit, 0);
  EXPECT_THAT(legs.out, Not(HasSubstr("crashed")));
  EXPECT_THAT(legs.err, HasSubstr("these entries contain no failure of legs"));
}

TEST_F(HistoryWhy, UntilATimeIsWhyItWasSoThen) {
  Add("", "machine_usable", 0, "the machine is Active", "Active");
  AddCrash("legs");
  Add("", "switch_done", 0, "the machine is LowPower", "LowPower");
  AddCrash("lidar");
  const Ran ran = Why({"--until", "2026-05-28T20:26:41Z"});
  EXPECT_THAT(ran.out, AllOf(HasSubstr("last failure: legs crashed"),
                             HasSubstr("the machine went to Active")))
      << ran.err;
}

TEST_F(HistoryWhy, OfLevelErrorIsTheFailureAlone) {
  Add("", "machine_usable", 0, "the machine is Active", "Active");
  AddCrash("lidar");
  const Ran ran = Why({"--level", "error"});
  EXPECT_THAT(ran.out, AllOf(HasSubstr("last failure: lidar crashed"),
                             Not(HasSubstr("the machine went to"))));
}

TEST_F(HistoryWhy, RefusesOptionsThatItCannotFollow) {
  Add("", "machine_usable", 0, "the machine is Active", "Active");
  EXPECT_EQ(Why({"--event", "actuator_crashed"}).exit, 2);
  EXPECT_EQ(Why({"--csv"}).exit, 2);
  const Ran state = Why({"Active", "--level", "error"});
  EXPECT_EQ(state.exit, 2);
  EXPECT_THAT(state.err, HasSubstr("--why Active"));
}

// A refused request was "the last failure", and the crash before it was not named.
TEST_F(HistoryWhy, ARefusedRequestDoesNotHideACrash) {
  Add("", "machine_usable", 0, "the machine is Protected", "Protected");
  AddCrash("lidar");
  Add("", "switch_refused", kCodeStateInvalid, "switch to Active refused: lidar is lost");
  const Ran ran = Why();
  EXPECT_THAT(ran.out, ContainsRegex("last request: switch to Active refused: lidar is lost[^\n]*\n"
                                     "[^\n]*last failure: lidar crashed"));
}

// A crash of last month was "the last failure".
TEST_F(HistoryWhy, ACrashOfAnEarlierControllerDoesNotHideARefusedRequest) {
  AddCrash("lidar");
  epoch_ = Epoch(2);
  next_id_ = 1;
  Add("", "machine_usable", 0, "the machine is Protected", "Protected");
  Add("", "switch_refused", kCodeStateInvalid, "switch to Active refused: the battery is at 3 %");
  EXPECT_THAT(Why().out, AllOf(HasSubstr("last failure: switch to Active refused"),
                               Not(HasSubstr("lidar")), Not(HasSubstr("last request"))));
}

// After a lost disk it takes a higher epoch than one that it has received.
TEST_F(HistoryWhy, ACrashBeforeItsControllerHasRaisedItsEpochIsNamed) {
  Add("", "machine_usable", 0, "the machine is Protected", "Protected");
  AddCrash("lidar");
  epoch_ = Epoch(9);
  Add("", "switch_refused", kCodeStateInvalid, "switch to Active refused: lidar is lost");
  EXPECT_THAT(Why().out, HasSubstr("last failure: lidar crashed"));
}

TEST_F(HistoryWhy, ARefusedRequestBeforeAChangeIsOver) {
  AddCrash("lidar");
  Add("", "switch_refused", kCodeStateInvalid, "switch to Active refused: lidar is lost");
  Add("", "switch_done", 0, "switch 4 is done", "Active");
  EXPECT_THAT(Why().out,
              AllOf(HasSubstr("last failure: lidar crashed"), Not(HasSubstr("last request"))));
}

TEST_F(HistoryWhy, ARefusedRequestIsNamedWhereNothingElseFailed) {
  Add("", "machine_usable", 0, "the machine is Protected", "Protected");
  Add("", "switch_refused", kCodeStateInvalid, "switch to Active refused: the battery is at 3 %");
  EXPECT_THAT(Why().out, HasSubstr("last failure: switch to Active refused"));
}

}  // namespace musher::cli::history_why_test
