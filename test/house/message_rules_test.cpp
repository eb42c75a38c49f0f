#include "musher/test/house/message_rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::house::message_rules_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

SourceFile PageWith(const std::string& section, const std::string& rows) {
  return {"docs/troubleshooting.md", "# Page\n\n## " + section +
                                         "\n\n| a | b | c | d |\n|---|---|---|---|\n" + rows +
                                         "\n## Next\n"};
}

TEST(MessageRules, APatternFitsWithAnyTextInItsPlaces) {
  EXPECT_TRUE(FitsPattern("legs is in Walk", "… is in …"));
  EXPECT_TRUE(FitsPattern("has no state 'Walk'", "has no state '…'"));
  EXPECT_TRUE(FitsPattern("is up", "is up"));
  EXPECT_TRUE(FitsPattern("is up", "is up…"));
  EXPECT_FALSE(FitsPattern("is up again", "is up"));
  EXPECT_FALSE(FitsPattern("legs was in Walk", "… is in …"));
  EXPECT_FALSE(FitsPattern("has no state 'Walk' now", "has no state '…'"));
}

const std::vector<SourceFile> kRecords = {
    {"lifecycle/event_name.hpp", "{\n    \"\",\n    \"lost\",\n    \"found\",\n});"},
    {"test/golden/record_texts.expected",
     "Lost\n  lost\n  legs are lost\n    actuator = \"legs\"\n"}};

TEST(MessageRules, AcceptAPageWithEverySentence) {
  const SourceFile page = PageWith("Records and faults",
                                   "| `… are lost` | `lost` | why | do |\n"
                                   "| `found` | `found` | why | – |\n");
  EXPECT_THAT(UnexplainedRecords(page, kRecords), IsEmpty());
}

TEST(MessageRules, ReportAnEventASentenceAndACureThatAreMissing) {
  const SourceFile page = PageWith("Records and faults",
                                   "| `… is lost` | `lost` | why | do |\n"
                                   "| `gone` | `gone` | why | do |\n"
                                   "| `found` | `found` | why | |\n");
  EXPECT_THAT(
      UnexplainedRecords(page, kRecords),
      ElementsAre("there is no event gone", "not a sentence, an event, a cause and a cure: found",
                  "no row explains the event found", "no row of lost explains: legs are lost"));
}

TEST(MessageRules, ReportAFindingWithoutARowAndARowWithoutAFinding) {
  const SourceFile page = PageWith("Errors of a config",
                                   "| `unknown key \"…\"` | why | do |\n"
                                   "| `too many legs` | why | do |\n");
  const std::vector<SourceFile> tree = {
      {"test/golden/configs/bad/a.expected",
       "a.toml:1:1: error: legs: unknown key \"x\"\na.toml:2:1: warning: arms: too short\n"}};
  EXPECT_THAT(
      UnexplainedFindings(page, tree),
      ElementsAre("no row explains: arms: too short", "no example of a config has: too many legs"));
}

const SourceFile kRefusalForms = {
    "lifecycle/refusal.hpp",
    "    {Refusal::kBusy, kCodeTargetBusy, \"{actuator} is busy{with?}\"},\n"
    "    {Refusal::kQuoted, kCodeUnSupport,\n     \"no key \\\"a\\\" \"\n     \"in {file}\"},\n"};

TEST(MessageRules, AcceptARowForEachRefusal) {
  const SourceFile page = PageWith("Refusals",
                                   "| `… is busy…` | why | do |\n"
                                   "| `no key \"a\" in …` | why | do |\n");
  EXPECT_THAT(UnexplainedRefusals(page, {kRefusalForms}), IsEmpty());
}

TEST(MessageRules, ReportARefusalWithoutARowAndARowWithoutARefusal) {
  const SourceFile page = PageWith("Refusals",
                                   "| `… is busy…` | why | |\n"
                                   "| `no key \"b\" in …` | why | do |\n");
  EXPECT_THAT(UnexplainedRefusals(page, {kRefusalForms}),
              ElementsAre("no row explains kQuoted: no key \"a\" in …",
                          "not a sentence, a cause and a cure: … is busy…",
                          "nothing is refused with: no key \"b\" in …"));
}

TEST(MessageRules, ReportARefusalThatNoTestProvokes) {
  const SourceFile test = {"test/lifecycle/a_test.cpp",
                           "Says(Refusal::kBusyWith); Refusal::kQuoted"};
  EXPECT_THAT(UntestedRefusals({kRefusalForms, test}),
              ElementsAre("no test provokes Refusal::kBusy"));
}

TEST(MessageRules, ReportARefusalOfApplicationsWithoutARowOrATest) {
  const SourceFile forms = {
      "application/refusal.hpp",
      "    {ApplicationRefusal::kPaused, kCodeStateInvalid, \"it waits\"},\n"};
  EXPECT_THAT(UnexplainedRefusals(PageWith("Refusals", "| `it waits` | why | do |\n"), {forms}),
              IsEmpty());
  EXPECT_THAT(UnexplainedRefusals(PageWith("Refusals", ""), {forms}),
              ElementsAre("no row explains kPaused: it waits"));
  EXPECT_THAT(UntestedRefusals({forms}), ElementsAre("no test provokes Refusal::kPaused"));
  const SourceFile test = {"test/application/a_test.cpp", "ApplicationRefusal::kPaused"};
  EXPECT_THAT(UntestedRefusals({forms, test}), IsEmpty());
}

TEST(MessageRules, ReportARefusalWhoseSentenceIsElsewhere) {
  const std::vector<SourceFile> tree = {
      {"lifecycle/switch/plan.cpp", "return Error{kCodeTargetBusy,\n             \"it is busy\"};"},
      {"lifecycle/switch/other.cpp", "return Error{kCodeTargetBusy, why};"},
      {"application/a.cpp", "return Error{kCodeStateInvalid, name + \" waits\"};"},
      {"controller/a.cpp", "return Error{kCodeTargetBusy, \"it is busy\"};"}};
  EXPECT_THAT(RefusalsElsewhere(tree),
              ElementsAre("lifecycle/switch/plan.cpp", "application/a.cpp"));
}

TEST(MessageRules, ReportASentenceThatNoProgramPrints) {
  const std::vector<SourceFile> tree = {
      {"controller/a.cpp", "Print(\"no controller in \"\n      \"namespace '\" + name);"}};
  EXPECT_THAT(
      SentencesOfNoProgram(
          PageWith("Credentials", "| `no controller in namespace '…'` | why | do |\n"), tree),
      IsEmpty());
  EXPECT_THAT(SentencesOfNoProgram(
                  PageWith("Credentials", "| `no controller in … the house` | why | do |\n"), tree),
              ElementsAre("no program prints ' the house'"));
}

}  // namespace musher::house::message_rules_test
