// Nothing is lost between the decision code's values and their recording. That no field is missing
// in the first place is checked when fields.hpp is compiled.

#include "musher/controller/journal/encoding.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include "musher/test/controller/recording/any_value.hpp"

namespace musher::recording::encoding_test {

using ::testing::HasSubstr;

TEST(Encoding, IsReadableAndLeavesDefaultsOut) {
  EXPECT_EQ(
      EncodeEvent(event::ProcessEnded{3, 4711, false, "killed by SIGSEGV"}, Time(Milliseconds(5))),
      R"({"event":"ProcessEnded","now":5000000,"actuator":3,"pid":4711,)"
      R"("how":"killed by SIGSEGV"})");
  EXPECT_EQ(EncodeEvent(event::TimePassed{}, Time()), R"({"event":"TimePassed","now":0})");
  Machine machine;
  machine.phase = Phase::kRunning;
  machine.fallback.target = "";
  EXPECT_EQ(EncodeSnapshot({"cafe", machine}),
            R"({"config_hash":"cafe","machine":{"phase":"running","fallback":""}})");
}

RC_GTEST_PROP(Encoding, GivesEveryEventBack, ()) {
  TimedEvent event{AnyEvent(), {}};
  MakeAny(event.now);
  const auto read = DecodeEvent(EncodeEvent(event.event, event.now));
  RC_ASSERT(read.ok());
  RC_ASSERT(read.value() == event);
}

RC_GTEST_PROP(Encoding, GivesEveryMachineBack, ()) {
  const Machine machine = AnyMachine();
  const auto read = DecodeSnapshot(EncodeSnapshot({"cafe", machine}));
  RC_ASSERT(read.ok());
  RC_ASSERT(read.value().machine == machine);
}

RC_GTEST_PROP(Encoding, GivesEveryConfigBack, (const std::string& file, const std::string& text)) {
  const ConfigText config{file, "cafe", text};
  const auto read = DecodeConfig(EncodeConfig(config));
  RC_ASSERT(read.ok());
  RC_ASSERT(read.value() == config);
}

RC_GTEST_PROP(Encoding, SurvivesDamage, ()) {
  std::string text = EncodeSnapshot({"cafe", AnyMachine()});
  for (int wounds = *rc::gen::inRange(1, 4); wounds > 0; --wounds) {
    text[*rc::gen::inRange<std::size_t>(0, text.size())] = *rc::gen::arbitrary<char>();
  }
  const auto read = DecodeSnapshot(text);  // a machine or a reason, but no crash
  if (!read) RC_ASSERT(!read.error().message.empty());
}

TEST(Encoding, KeepsTextsThatAreNotUtf8) {
  const Event event = event::ProcessNotStarted{1, "no \xff\xfe "};
  const std::string text = EncodeEvent(event, Time());
  EXPECT_THAT(text, HasSubstr(R"("why":{"hex":"6e6f20fffe20"})"));
  EXPECT_EQ(DecodeEvent(text).value().event, event);
}

TEST(Encoding, KeepsDefaultsOfWhatIsMissingAndPassesOverWhatIsNotKnown) {
  const auto read = DecodeEvent(R"({"event":"ProcessEnded","now":1,"actuator":2,"mood":"bad"})");
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read.value().event, Event(event::ProcessEnded{2, 0, false, ""}));
}

TEST(Encoding, OfTheEndOfAProcessHasItsExitCodeAndReadsEndsWithoutOne) {
  const std::string before = R"({"event":"ProcessEnded","now":1,"pid":7,"how":"exit code 2: no"})";
  const Event without = event::ProcessEnded{0, 7, false, "exit code 2: no"};
  EXPECT_EQ(DecodeEvent(before).value().event, without) << "recorded before there was one";
  EXPECT_EQ(EncodeEvent(event::ProcessEnded{0, 7, false, "exit code 2: no", 2}, Time(Duration(1))),
            before.substr(0, before.size() - 1) + R"(,"exit_code":2})");
}

TEST(Encoding, ReportsWhereItCannotBeRead) {
  const auto error_of = [](const char* text) {
    const auto read = DecodeEvent(text);
    return read.ok() ? "" : read.error().message;
  };
  EXPECT_EQ(error_of(R"({"event":"Slept","now":1})"), "event: 'Slept' is not known");
  EXPECT_EQ(error_of(R"({"event":"TimePassed"})"),
            "now: expected a whole number that fits, found null");
  EXPECT_EQ(error_of(R"([])"), "expected an object, found []");
  EXPECT_EQ(error_of(R"({"event":"StatusSeen","now":1,"report":{"pid":"x"}})"),
            "report.pid: expected a whole number that fits, found \"x\"");
  EXPECT_EQ(error_of(R"({"event":"StatusSeen","now":1,"report":{"pid":4294967296}})"),
            "report.pid: expected a whole number that fits, found 4294967296");
  EXPECT_EQ(error_of(R"({"event":"Begin","now":1,"running":[true,2]})"),
            "running[1]: expected true or false, found 2");
  EXPECT_EQ(error_of(R"({"event":"Replied","now":1,"verdict":"maybe"})"),
            "verdict: expected one of done, refused, failed, found \"maybe\"");
  EXPECT_EQ(error_of(R"({"event":"Vanished","now":1,"how":{"hex":"0g"}})"),
            "how: expected pairs of hex digits, found \"0g\"");
  EXPECT_EQ(error_of(R"({"event":"TimePassed","now":-9223372036854775807})"),
            "now: expected a time that can be computed with, found -9223372036854775807");
  EXPECT_THAT(error_of(R"({"event":)"), HasSubstr("line 1, column 10"));
}

}  // namespace musher::recording::encoding_test
