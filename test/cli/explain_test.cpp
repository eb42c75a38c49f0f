#include <gmock/gmock.h>

#include "musher/cli/config/key_reference.hpp"
#include "musher/test/cli/program.hpp"

namespace musher::cli::explain_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Explain, ShowsAKeyAsTheReferenceHasIt) {
  const Ran ran = RunProgram({"explain", "default_time"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_EQ(ran.out,
            "[controller] default_time\n"
            "  type     ms\n"
            "  default  required\n"
            "  the time limit of a state for which the actuator has no time of its own\n");
}

TEST(Explain, FindsAKeyByItsTable) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"policy.battery.topic"}, {"[policy.battery]", "topic"}}) {
    std::vector<std::string> line = words;
    line.insert(line.begin(), "explain");
    EXPECT_THAT(RunProgram(line).out,
                AllOf(HasSubstr("[policy.battery] topic\n"), Not(HasSubstr("[policy.low_power]"))));
  }
  EXPECT_THAT(RunProgram({"explain", "topic"}).out, AllOf(HasSubstr("[policy.battery] topic\n"),
                                                          HasSubstr("[policy.low_power] topic\n")));
  EXPECT_THAT(RunProgram({"explain", "actuator.audio.restart"}).out,
              HasSubstr("[actuator.<name>] restart\n"));
  EXPECT_THAT(RunProgram({"explain", "view"}).out,
              AllOf(HasSubstr("[view]\n"), HasSubstr("[view] port\n")));
}

TEST(Explain, SuggestsTheKeyThatWasMeant) {
  const Ran ran = RunProgram({"explain", "retart"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("no key 'retart'; did you mean 'restart'?"));
  EXPECT_EQ(RunProgram({"explain", "[]"}).exit, 2);
}

TEST(Explain, HasADocumentForPrograms) {
  EXPECT_THAT(RunProgram({"explain", "journal_size_mb", "--json"}).out,
              HasSubstr(R"("table":"[controller]","key":"journal_size_mb",)"));
}

TEST(Explain, HasNoMarkupOfLinks) {
  for (const KeyReference& key : AllKeys()) {
    EXPECT_THAT(key.type + key.otherwise + key.meaning, Not(HasSubstr("](")));
    EXPECT_FALSE(key.table.empty()) << key.key;
  }
}

}  // namespace musher::cli::explain_test
