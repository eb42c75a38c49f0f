#include "musher/controller/cli/console/console.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>

#include "musher/controller/cli/console/table.hpp"

namespace musher::cli::console_test {

TEST(Console, ColoursOnlyOnATerminalByDefault) {
  setenv("TERM", "xterm", 1);
  unsetenv("NO_COLOR");
  EXPECT_TRUE(WantsColour(ColourWhen::kAuto, true));
  EXPECT_FALSE(WantsColour(ColourWhen::kAuto, false));
  EXPECT_TRUE(WantsColour(ColourWhen::kAlways, false));
  EXPECT_FALSE(WantsColour(ColourWhen::kNever, true));
  setenv("TERM", "dumb", 1);
  EXPECT_FALSE(WantsColour(ColourWhen::kAuto, true));
}

TEST(Console, RespectsNoColor) {
  setenv("TERM", "xterm", 1);
  setenv("NO_COLOR", "1", 1);
  EXPECT_FALSE(WantsColour(ColourWhen::kAuto, true));
  EXPECT_TRUE(WantsColour(ColourWhen::kAlways, true));
  setenv("NO_COLOR", "", 1);  // empty counts as not set
  EXPECT_TRUE(WantsColour(ColourWhen::kAuto, true));
  unsetenv("NO_COLOR");
}

TEST(Console, LetsNoMessageDriveTheTerminal) {
  EXPECT_EQ(Printable("a\x1b[2Jb\nc\x7f\td\u00e9"), "a [2Jb c  d\u00e9");
}

TEST(Console, PrintsAFailureOnceAsTextAndOnceAsJson) {
  std::ostringstream out;
  std::ostringstream err;
  Console people(out, err, {});
  EXPECT_EQ(people.Fail({ExitCode::kNoController, {105, "no\nanswer"}}), ExitCode::kNoController);
  EXPECT_EQ(out.str(), "");
  EXPECT_EQ(err.str(), "musher: no answer\n");

  Console programs(out, err, {true, false, false});
  EXPECT_EQ(programs.Fail({ExitCode::kNoAnswer, {107, "silence"}, 12}), ExitCode::kNoAnswer);
  EXPECT_EQ(out.str(), "{\"error\":\"silence\",\"code\":107,\"switch\":12}\n");
}

TEST(Table, AlignsColumnsByCharactersAndEndsLinesWithoutSpaces) {
  Table table({"NAME", "STATE", "NOTE"});
  table.Add({{"a"}, {"Active", Style::kGood}, {""}});
  table.Add({{"b\u00e9e"}, {""}, {"x"}});
  EXPECT_EQ(table.Text(false),
            "NAME  STATE   NOTE\n"
            "a     Active\n"
            "b\u00e9e           x\n");
}

TEST(Table, ColoursTextButNotTheSpacesAroundIt) {
  Table table({"N", "S"});
  table.Add({{"a"}, {"b", Style::kBad}});
  EXPECT_EQ(table.Text(true), "\x1b[2mN\x1b[0m  \x1b[2mS\x1b[0m\na  \x1b[31mb\x1b[0m\n");
}

}  // namespace musher::cli::console_test
