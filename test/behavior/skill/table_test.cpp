#include "musher/behavior/skill/table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/behavior/skill/check.hpp"

namespace musher::skill::table_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> ProblemsOf(const Table& table) {
  std::vector<std::string> lines;
  for (const Problem& problem : Check(table)) {
    lines.push_back(SeverityName(problem.severity) + ": " + problem.where + ": " + problem.what);
  }
  return lines;
}

TEST(SkillCheck, FindsNothingInASkillWhoseStatesAllEnd) {
  Table table;
  const StateId planning = table.State("PLANNING");
  const StateId moving = table.State("MOVING");
  table.To(planning, moving, "planned");
  table.To(moving, planning, "replan");
  table.To(moving, kSucceeded, "there");
  EXPECT_THAT(ProblemsOf(table), IsEmpty());
  EXPECT_TRUE(CheckErrors("walk", table));
}

TEST(SkillCheck, RefusesAStateFromWhichNoEndIsReached) {
  Table table;
  const StateId a = table.State("A");
  const StateId b = table.State("B");
  const StateId c = table.State("C");
  table.To(a, kSucceeded, "done");
  table.To(a, b, "lost");
  table.To(b, c, "");
  table.To(c, b, "");
  EXPECT_THAT(ProblemsOf(table),
              ElementsAre("error: B: no declared transitions lead from it to an end",
                          "error: C: no declared transitions lead from it to an end"));
  EXPECT_EQ(CheckErrors("walk", table).error().message,
            "walk: B: no declared transitions lead from it to an end\n"
            "walk: C: no declared transitions lead from it to an end");
}

TEST(SkillCheck, RefusesAnEndThatIsLeftAndAWayBackToIdle) {
  Table table;
  const StateId a = table.State("A");
  table.To(a, kSucceeded, "done");
  table.To(kFailed, a, "retry");
  table.To(a, kIdle, "again");
  table.To(kIdle, kFailed, "refused");
  EXPECT_THAT(
      ProblemsOf(table),
      ElementsAre("error: IDLE: declares a transition to FAILED; a run begins in the first state",
                  "error: FAILED: is an end, but declares a transition to A",
                  "error: A: declares a transition to IDLE; a skill that has ended stays "
                  "there until its reset"));
}

TEST(SkillCheck, WarnsOfASkillThatNeverSucceedsAndOfAStateThatIsNeverReached) {
  Table table;
  const StateId a = table.State("FOLLOWING");
  const StateId b = table.State("LOST");
  table.To(a, kFailed, "lost");
  table.To(a, kFailed, "lost");
  table.To(b, kFailed, "");
  EXPECT_THAT(ProblemsOf(table),
              ElementsAre("warning: FOLLOWING: declares its transition to FAILED twice",
                          "warning: LOST: no transition leads to it",
                          "warning: SUCCEEDED: no transition leads to it: it never succeeds"));
  EXPECT_TRUE(CheckErrors("follow", table)) << "warnings are no errors";
}

TEST(SkillCheck, RefusesDeclarationsThatContradictEachOther) {
  EXPECT_THAT(ProblemsOf(Table()), ElementsAre("error: : declares no state"));
  Table table;
  table.To(table.State("A"), kSucceeded, "");
  table.State("FAILED");
  table.To(StateId{77}, kSucceeded, "never");
  table.Takes("speed", 1.0, "m/s");
  table.Needs("speed", Kind::kNumber, "m/s");
  table.Needs("a/b", Kind::kText, "");
  EXPECT_THAT(table.errors(),
              ElementsAre("state FAILED: is declared twice",
                          "a transition (never) is from or to a state that was not declared",
                          "parameter speed: is declared twice",
                          "parameter a/b: a name has no slash and no control characters"));
  EXPECT_FALSE(CheckErrors("x", table));
}

class AParameter : public ::testing::Test {
 protected:
  AParameter() {
    table_.Needs("goal_pos", Kind::kNumbers, "m, in the map");
    table_.Takes("altitude", 1.0, "m");
    table_.Takes("tries", std::int64_t{3}, "");
    table_.Takes("save", false, "");
    table_.Takes("camera", std::string("front"), "");
  }
  std::string ErrorOf(const std::vector<std::pair<std::string, std::string>>& given) {
    const Result<Values> values = table_.Parse(given);
    return values ? "" : values.error().message;
  }

  Table table_;
};

TEST_F(AParameter, IsReadFromTextByItsKindAndHasItsDefault) {
  const Result<Values> values = table_.Parse({{"goal_pos", " [10, -20.5,0] "},
                                              {"save", "true"},
                                              {"camera", "\"rear view\""},
                                              {"tries", "5"}});
  ASSERT_TRUE(values) << values.error().message;
  EXPECT_EQ(values.value().Get<Numbers>("goal_pos", {}), (Numbers{10, -20.5, 0}));
  EXPECT_EQ(values.value().Number("altitude"), 1.0);
  EXPECT_TRUE(values.value().Get("save", false));
  EXPECT_EQ(values.value().Text("camera"), "rear view");
  EXPECT_EQ(values.value().Get<std::int64_t>("tries", 0), 5);
}

TEST_F(AParameter, IsRefusedWithEveryError) {
  EXPECT_EQ(ErrorOf({{"goal_pos", "[1, two]"}, {"altitud", "2"}, {"tries", "1.5"}}),
            "parameter goal_pos: expected a list of numbers, found [1, two]\n"
            "there is no parameter altitud; did you mean 'altitude'?\n"
            "parameter tries: expected an integer, found 1.5");
  EXPECT_EQ(ErrorOf({}), "the parameter goal_pos is missing: a list of numbers, m, in the map");
  EXPECT_THAT(ErrorOf({{"goal_pos", "[]"}, {"goal_pos", "[]"}}), HasSubstr("is given twice"));
}

TEST_F(AParameter, IsNeverInfiniteOrNotANumber) {
  for (const char* text : {"nan", "inf", "-inf", "1e999", ""}) {
    EXPECT_NE(ErrorOf({{"goal_pos", "[]"}, {"altitude", text}}), "") << text;
    EXPECT_NE(ErrorOf({{"goal_pos", "[" + std::string(text) + ",1]"}}), "") << text;
  }
  const Values given{{"goal_pos", Numbers{}}, {"altitude", std::nan("")}};
  EXPECT_FALSE(table_.Complete(given));
}

TEST_F(AParameter, TakesAnIntegerAsANumberButNoNumberAsAnInteger) {
  const Values given{{"goal_pos", Numbers{}}, {"altitude", std::int64_t{2}}};
  EXPECT_EQ(table_.Complete(given).value().Number("altitude"), 2.0);
  EXPECT_FALSE(table_.Complete({{"goal_pos", Numbers{}}, {"tries", 2.0}}));
}

TEST_F(AParameter, ReadsTheTextThatAValueIsWrittenAs) {
  for (const Value& value :
       {Value(true), Value(std::int64_t{-7}), Value(0.1), Value(Numbers{1, 2.5}), Value("car")}) {
    const Result<Value> read = Parse(KindOf(value), ToText(value));
    ASSERT_TRUE(read);
    EXPECT_EQ(read.value(), value);
  }
}

TEST(SkillTable, TakesAParameterByEachOfItsNames) {
  Table table;
  table.Needs("path", Kind::kText, "the file");
  table.Also("path", "file");
  EXPECT_EQ(table.Complete({{"file", "a"}}).value().Text("path"), "a");
  EXPECT_EQ(table.Parse({{"file", "a"}}).value().Text("path"), "a");
  EXPECT_EQ(ToText(table.parameters()[0]), "path: a text, required (the file; also file)");
  for (const std::string& message : {table.Complete({{"file", "a"}, {"path", "b"}}).error().message,
                                     table.Parse({{"path", "a"}, {"file", "b"}}).error().message}) {
    EXPECT_EQ(message, "parameter path: is given twice");
  }
  table.Also("pth", "other");
  table.Also("path", "file");
  EXPECT_THAT(table.errors(), ElementsAre("parameter other: is no other name of pth",
                                          "parameter file: is no other name of path"));
}

TEST(SkillTable, SaysWhyItDoesNotTakeAParameter) {
  Table table;
  table.RefusesParameter("cancel", "cancel the goal");
  EXPECT_EQ(table.Parse({{"cancel", "true"}}).error().message,
            "there is no parameter cancel: cancel the goal");
  EXPECT_EQ(table.Complete({{"cancel", true}}).error().message,
            "there is no parameter cancel: cancel the goal");
}

TEST(Settings, ReplaceLimitsAndDefaultsAndAreRefusedWithTheNearestName) {
  Table table;
  table.State("MOVING", std::chrono::seconds(9));
  table.Takes("altitude", 1.0, "m");
  Settings settings{.run = std::chrono::seconds(3), .retries = 7};
  settings.states = {{"MOVING", std::chrono::seconds(4)}};
  settings.parameters.Set("altitude", 2.5);
  ASSERT_TRUE(table.Apply(settings));
  EXPECT_EQ(table.limits().run, std::chrono::seconds(3));
  EXPECT_EQ(table.limits().cancel, Limits{}.cancel);
  EXPECT_EQ(table.limits().retries, 7);
  EXPECT_EQ(table.LimitOf(*table.Find("MOVING")), std::chrono::seconds(4));
  EXPECT_EQ(table.Complete({}).value().Number("altitude"), 2.5);

  settings.states = {{"MOVNG", std::chrono::seconds(4)}, {"FAILED", std::chrono::seconds(4)}};
  settings.parameters.Set("hight", 1.0);
  EXPECT_EQ(table.Apply(settings).error().message,
            "there is no state MOVNG with a time; did you mean 'MOVING'?\n"
            "there is no state FAILED with a time\n"
            "there is no parameter hight");
}

TEST(SkillTable, HasEachPartOfTheRobotOnce) {
  Table table;
  for (const char* part : {"base", "arm", "base"}) table.Uses(part);
  EXPECT_THAT(table.parts(), ::testing::ElementsAre("base", "arm"));
  EXPECT_TRUE(table.errors().empty());
  table.Uses("");
  EXPECT_THAT(table.errors(), ::testing::ElementsAre("a part has no name"));
}

TEST(SkillTable, SaysWhatTheSkillDoesAndWhatItTakes) {
  Table table;
  table.Does("Rises to an altitude");
  table.Takes("altitude", 1.0, "m above the ground");
  table.Needs("names", Kind::kText, "");
  EXPECT_EQ(table.summary(), "Rises to an altitude");
  EXPECT_EQ(ToText(table.parameters()[0]), "altitude: a number, default 1 (m above the ground)");
  EXPECT_EQ(ToText(table.parameters()[1]), "names: a text, required");
}

}  // namespace musher::skill::table_test
