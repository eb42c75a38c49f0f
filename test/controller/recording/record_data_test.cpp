// What programs read of a record in the journal.

#include "musher/controller/journal/record_data.hpp"

#include <gtest/gtest.h>

#include "musher/lifecycle/record/texts.hpp"

namespace musher::record_data_test {

action::Record RecordOf(const RecordText& text) {
  action::Record record;
  record.message = text.message;
  record.arguments = text.arguments;
  return record;
}

TEST(RecordData, HasNumbersAsNumbersAndTextsAsTexts) {
  EXPECT_EQ(DataOf(RecordOf(texts::RestartScheduled("legs", Milliseconds(1500), 1, 5))),
            R"({"arguments":{"actuator":"legs","delay_ms":1500,"restart":1,"limit":5}})");
  EXPECT_EQ(DataOf(RecordOf(texts::BatterySwitchDown(18, true, "Protected"))),
            R"({"arguments":{"percent":18,"charging":true,"target":"Protected"}})");
  EXPECT_EQ(DataOf(RecordOf(texts::EpochOutOfRange(Epoch(~std::uint64_t{0})))),
            R"({"arguments":{"epoch":18446744073709551615}})");
}

TEST(RecordData, LeavesOutWhatIsNotKnown) {
  EXPECT_EQ(DataOf(RecordOf(texts::ActuatorPresent("legs", "SetUp", 0))),
            R"({"arguments":{"actuator":"legs","state":"SetUp"}})");
  EXPECT_EQ(DataOf(RecordOf(texts::StopIntentLate())), "");
}

TEST(RecordData, HasTheOutcomeOfASwitchBesideTheArguments) {
  action::Record record = RecordOf(texts::SwitchEnded(4, SwitchOutcome::kDone, ""));
  record.of_switch = {"Active", SwitchOutcome::kDone, "Active"};
  EXPECT_EQ(DataOf(record), R"({"target":"Active","state":"Active","outcome":"done",)"
                            R"("arguments":{"number":4,"outcome":"done"}})");
}

TEST(RecordData, IsABacktraceAsItIs) {
  action::Record record = RecordOf(texts::BacktraceTaken("legs"));
  record.data = "#0 in main";
  EXPECT_EQ(DataOf(record), "#0 in main");
}

TEST(RecordData, ReplacesWhatIsNotUtf8) {
  EXPECT_EQ(DataOf(RecordOf(texts::Crashed("at \xff"))),
            "{\"arguments\":{\"how\":\"at \xef\xbf\xbd\"}}");
}

}  // namespace musher::record_data_test
