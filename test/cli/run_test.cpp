// The program from its command line to its exit code, where no controller is needed.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "musher/controller/journal/journal.hpp"
#include "musher/ota/signature.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/test/cli/robot.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::run_test {

using ::testing::HasSubstr;

TEST(Program, EndsWithTwoAndAReasonWhenItIsUsedWrongly) {
  const Ran ran = RunProgram({"fly"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_EQ(ran.out, "");
  EXPECT_EQ(ran.err, "musher: unknown command 'fly'; see musher --help\n");
}

TEST(Program, AnswersWrongUseInJsonToo) {
  const Ran ran = RunProgram({"set", "--json"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.out, ::testing::StartsWith(R"({"error":"STATE is required)"));
  EXPECT_THAT(ran.out, HasSubstr(R"("code":110,"switch":null,)"));
  EXPECT_NE(ran.err, "");
}

TEST(Program, PrintsHelpAndVersionOnStandardOutput) {
  const Ran help = RunProgram({"--help"});
  EXPECT_EQ(help.exit, 0);
  EXPECT_THAT(help.out, HasSubstr("Usage: musher [OPTIONS] COMMAND"));
  EXPECT_EQ(help.err, "");
  EXPECT_EQ(RunProgram({"--version"}).exit, 0);
}

TEST(Program, RefusesToStartABadConfig) {
  const TempFolder folder;
  std::ofstream(folder / "bad.toml") << "[controller]\n";
  const Ran ran = RunProgram({"up", folder / "bad.toml"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("bad.toml:1:"));
  const Ran json = RunProgram({"up", folder / "bad.toml", "--json"});
  EXPECT_EQ(json.exit, 2);
  EXPECT_THAT(json.out, HasSubstr(R"("diagnostics":[{)"));
}

TEST(Program, NamesTheCommandThatStartsAnActuatorWhereOneIsGivenAsTheFile) {
  const Ran ran = RunProgram({"up", "audio"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("`musher restart audio` an actuator of a machine that runs"));
}

TEST(Program, RefusesToStartAMachineInANamespaceThatIsNotItsOwn) {
  const TempFolder folder;
  std::ofstream(folder / "dog.toml") << kRobotToml;
  const Ran ran = RunProgram({"up", folder / "dog.toml", "--namespace", "pack"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("--namespace differs from the config"));
}

TEST(Program, ReadsTheJournalOfAnExitedController) {
  const TempFolder folder;
  const std::string file = folder / "journal.sqlite";
  {
    Journal journal(file, {});
    journal.Append(
        JournalEntry{1'000'000'000, 1, 3, 12, "switch", "legs", 107, "too late", "", 5, 4, ""});
    journal.Append(JournalEntry{5'000'000'000, 2, 3, 13, "switch", "", 0, "done", "", 6, 0,
                                "Active", "switch_done"});
  }
  const Ran all = RunProgram({"history", "--journal", file, "--json"});
  EXPECT_EQ(all.exit, 0);
  EXPECT_EQ(all.out, R"({"entries":[{"time":"1970-01-01T00:00:01.000Z","epoch":3,"switch":12,)"
                     R"("kind":"switch","event":null,"actuator":"legs","code":107,)"
                     R"("message":"too late","id":5,"cause":4,"new_state":null,"data":null,)"
                     R"("arguments":{}},)"
                     R"({"time":"1970-01-01T00:00:05.000Z","epoch":3,"switch":13,"kind":"switch",)"
                     R"("event":"switch_done","actuator":null,"code":0,"message":"done","id":6,)"
                     R"("cause":null,)"
                     R"("new_state":"Active","data":null,"arguments":{}}],"damage":null})"
                     "\n");
  const Ran since = RunProgram({"history", "--journal", file, "--since", "1970-01-01T00:00:02Z"});
  EXPECT_THAT(since.out, Not(HasSubstr("too late")));
  EXPECT_THAT(since.out, HasSubstr("switch   done"));
  const Ran newest = RunProgram({"history", "--journal", file, "--lines", "1"});
  EXPECT_THAT(newest.out, Not(HasSubstr("too late")));
}

TEST(Program, FiltersTheHistoryByEvent) {
  const TempFolder folder;
  const std::string file = folder / "journal.sqlite";
  {
    Journal journal(file, {});
    for (const char* event : {"switch_started", "switch_done", "", "switch_done"}) {
      journal.Append(JournalEntry{1, 1, 3, 12, "switch", "", 0, "text", "", 1, 0, "", event});
    }
  }
  const auto entries = [&](const std::vector<std::string>& options) {
    std::vector<std::string> words = {"history", "--journal", file, "--json"};
    words.insert(words.end(), options.begin(), options.end());
    const std::string out = RunProgram(words).out;
    std::size_t count = 0;
    for (std::size_t at = out.find(R"("time")"); at != std::string::npos; ++count) {
      at = out.find(R"("time")", at + 1);
    }
    return count;
  };
  EXPECT_EQ(entries({}), 4U);
  EXPECT_EQ(entries({"--event", "switch_done"}), 2U);
  EXPECT_EQ(entries({"--event", "switch_done", "--lines", "1"}), 1U);
  EXPECT_EQ(entries({"--event", "switch_refused"}), 0U);
  const Ran unknown = RunProgram({"history", "--journal", file, "--event", "switch_don"});
  EXPECT_EQ(unknown.exit, 2);
  EXPECT_THAT(unknown.err,
              HasSubstr("--event: unknown event 'switch_don'; did you mean 'switch_done'?"));
}

TEST(Program, ReportsAJournalThatCannotBeRead) {
  const Ran ran = RunProgram({"history", "--journal", "/no/such/journal", "--json"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.out, HasSubstr(R"({"error":)"));
  EXPECT_THAT(ran.err, HasSubstr("/no/such/journal: No such file or directory"));
}

TEST(Program, ReportsWhyADrawingCannotBeWritten) {
  const TempFolder folder;
  std::ofstream(folder / "dog.toml") << kRobotToml;
  const Ran ran = RunProgram({"graph", folder / "dog.toml", "-o", folder / "none/a.svg"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("none/a.svg: No such file or directory"));
}

TEST(Program, NamesTheKeyFileThatIsTheOtherOneOfThePair) {
  const TempFolder folder;
  const auto pair = ota::MakeKeyPair();
  ASSERT_TRUE(pair);
  std::ofstream(folder / "dog.key") << pair.value().private_pem;
  std::ofstream(folder / "dog.pub") << pair.value().public_pem;
  std::string robot = kRobotToml;  // an upgradable one
  for (std::size_t at = 0; (at = robot.find("LowPower")) != std::string::npos;) {
    robot.replace(at, std::string("LowPower").size(), "OTA");
  }
  std::ofstream(folder / "robot.toml") << robot;
  const Ran init =
      RunProgram({"ota", "init", folder / "root", "--from", "b100", "--key", folder / "dog.key"});
  EXPECT_EQ(init.exit, 2);
  EXPECT_THAT(init.err, HasSubstr("dog.key is not a public key but a private one"));
  const Ran bundle = RunProgram({"ota", "bundle", folder.path(), "--version", "1.0.0", "--key",
                                 folder / "dog.pub", "--out", folder / "b"});
  EXPECT_EQ(bundle.exit, 2);
  EXPECT_THAT(bundle.err,
              HasSubstr("dog.pub is a public key; a bundle is signed with the private"));
  EXPECT_THAT(bundle.err, Not(HasSubstr("chmod")));
}

TEST(Program, ListsTheTimesThatHistoryAccepts) {
  const Ran ran = RunProgram({"history", "--since", "soon"});
  EXPECT_EQ(ran.exit, 2);
  EXPECT_THAT(ran.err, HasSubstr("--since: invalid time 'soon'"));
  EXPECT_THAT(ran.err, ::testing::EndsWith("; see musher history --help\n"));
  EXPECT_THAT(RunProgram({"history", "--until", "late"}).err,
              HasSubstr("--until: invalid time 'late'"));
}

TEST(Program, WithoutArgumentsItIsOneScreenThatNamesTheHelp) {
  const Ran ran = RunProgram({});
  EXPECT_EQ(ran.exit, 0);
  EXPECT_LE(std::count(ran.out.begin(), ran.out.end(), '\n'), 23);
  EXPECT_THAT(ran.out, ::testing::AllOf(HasSubstr("musher estop"), HasSubstr("musher help ")));
}

TEST(Program, WithHelpItPrintsTheHelp) {
  const Ran help = RunProgram({"--help"});
  EXPECT_EQ(help.exit, 0);
  EXPECT_EQ(RunProgram({"help"}).out, help.out);
  EXPECT_EQ(RunProgram({"help", "set"}).out, RunProgram({"set", "--help"}).out);
  EXPECT_THAT(RunProgram({"set"}).err, ::testing::HasSubstr("; see musher set --help"));
}

}  // namespace musher::cli::run_test
