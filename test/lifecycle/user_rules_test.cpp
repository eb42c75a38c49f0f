// Rules of the user with a time: how they are read. Those of stable states are in
// test/search/proof_test.cpp.

#include "musher/lifecycle/config/user_rules.hpp"

#include <gmock/gmock.h>

#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::testing::user_rules_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(RulesWithATime, AreReadFromLines) {
  const MachineConfig config = MachineOf(2);
  const UserRulesReading read =
      ReadUserRules(config, "rules.txt",
                    "within 5 s of Error a in DeActive or exited\n\n"
                    "within 250 ms of LowPower machine in LowPower\nnever b Error\n"
                    "  within 1.5 min  of Active b in Active  # why\n");
  EXPECT_THAT(read.diagnostics, IsEmpty());
  EXPECT_EQ(read.rules.stable.size(), 1U);
  EXPECT_EQ(read.rules.size(), 4U);
  ASSERT_EQ(read.rules.timed.size(), 3U);
  const TimedRule& first = read.rules.timed[0];
  EXPECT_EQ(first.line, 1);
  EXPECT_EQ(first.within, std::chrono::seconds(5));
  EXPECT_EQ(first.of, "Error");
  EXPECT_EQ(first.subject, config.IndexOf("a"));
  EXPECT_THAT(first.states, ElementsAre(State("DeActive"), State()));
  EXPECT_EQ(read.rules.timed[1].within, Milliseconds(250));
  EXPECT_FALSE(read.rules.timed[1].subject);
  EXPECT_EQ(read.rules.timed[2].within, std::chrono::seconds(90));
  EXPECT_EQ(read.rules.timed[2].line, 5);
  EXPECT_EQ(read.rules.timed[2].text, "within 1.5 min of Active b in Active");
}

TEST(RulesWithATime, AreReportedWithThePlaceOfWhatIsWrong) {
  const auto error_of = [](const std::string& line) {
    const UserRulesReading read = ReadUserRules(MachineOf(2), "rules.txt", line);
    return read.diagnostics.size() == 1 && read.rules.empty()
               ? FormatDiagnostic(read.diagnostics.front())
               : "not one error";
  };
  EXPECT_EQ(error_of("within 5 sec of Error a in DeActive"),
            "rules.txt:1:10: error: there is no unit 'sec' of a time; use ms, s or min");
  EXPECT_EQ(error_of("within 5s of Error a in DeActive"),
            "rules.txt:1:8: error: expected a time such as 5 s, found '5s'");
  EXPECT_EQ(error_of("within 0 s of Error a in DeActive"),
            "rules.txt:1:8: error: expected a time from 1 ms to 1440 min, found '0 s'");
  for (const char* time : {"2000 min", "-1 s", "inf s", "nan s", "0.5 ms"}) {
    EXPECT_THAT(error_of("within " + std::string(time) + " of Error a in DeActive"),
                HasSubstr("1:8: error: expected a time from 1 ms to 1440 min"));
  }
  EXPECT_EQ(error_of("within 5 s of Eror a in DeActive"),
            "rules.txt:1:15: error: the machine has no state 'Eror'; did you mean 'Error'?");
  EXPECT_THAT(error_of("within 5 s of Error c in DeActive"), HasSubstr("rules.txt:1:21: error: "));
  EXPECT_EQ(error_of("within 5 s of Error a in DeActiv"),
            "rules.txt:1:26: error: a has no state 'DeActiv'; did you mean 'DeActive'?");
  const std::string form = "error: expected 'within TIME of STATE ACTUATOR in STATE";
  EXPECT_THAT(error_of("within 5 s of Error a DeActive"), HasSubstr("1:23: " + form));
  EXPECT_THAT(error_of("within 5 s of Error a in DeActive or"), HasSubstr("1:37: " + form));
  EXPECT_THAT(error_of("within 5 s of Error a in DeActive and"), HasSubstr("1:35: " + form));
  EXPECT_THAT(error_of("within 5"), HasSubstr("1:9: " + form));
}

}  // namespace musher::testing::user_rules_test
