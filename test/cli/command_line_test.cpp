#include "musher/cli/command_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <CLI/CLI.hpp>

#include <cstdlib>
#include <iterator>
#include <sstream>
#include <vector>

#include "musher/cli/grammar/grammar.hpp"

namespace musher::cli::command_line_test {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

using Words = std::vector<const char*>;

std::variant<CommandLine, ParseEnd> Parse(Words arguments) {
  arguments.insert(arguments.begin(), "musher");
  return ParseCommandLine(static_cast<int>(arguments.size()), arguments.data());
}

CommandLine Parsed(Words arguments) {
  auto parsed = Parse(std::move(arguments));
  if (auto* line = std::get_if<CommandLine>(&parsed)) return *line;
  ADD_FAILURE() << std::get<ParseEnd>(parsed).err;
  return {};
}

// The error of a command line that must be wrong.
std::string Wrong(Words arguments) {
  const auto parsed = Parse(std::move(arguments));
  const auto* end = std::get_if<ParseEnd>(&parsed);
  if (end == nullptr) return "nothing is wrong";
  EXPECT_EQ(end->exit, ExitCode::kUsage);
  EXPECT_EQ(end->out, "");
  return end->err;
}

struct Draw {
  std::string file;
  std::string format = "svg";
  bool marked = false;
};

TEST(Grammar, RunsTheCommandWithItsOptions) {
  Grammar grammar;
  auto [app, options] = grammar.Add<Draw>(
      "draw", "Draw a file",
      [](const Draw& draw, const GlobalOptions& global, Console& console) {
        console.Print(draw.file + " " + draw.format + (draw.marked ? " marked" : "") +
                      (global.json ? " json" : ""));
        return ExitCode::kNotDone;
      },
      "musher draw a.toml");
  app.add_option("FILE", options.file, "What to draw")->required();
  grammar.OneOf(app.add_option("--format", options.format, ""), {"svg", "dot"});
  app.add_flag("--marked", options.marked, "");
  const char* words[] = {"musher", "draw", "a.toml", "--format", "dot", "--marked", "--json"};
  const auto parsed = grammar.Parse(std::size(words), words);
  std::ostringstream out;
  Console console(out, out, {});
  const auto& line = std::get<CommandLine>(parsed);
  EXPECT_EQ(line.run(line.global, console), ExitCode::kNotDone);
  EXPECT_EQ(out.str(), "a.toml dot marked json\n");
}

TEST(CommandLine, EngagesAnEmergencyStopWithAReasonOfAnyWordsOrReleasesIt) {
  for (const auto& words :
       {Words{"estop"}, Words{"estop", "it", "smokes"}, Words{"estop", "--release"}}) {
    Parsed(words);
  }
  EXPECT_THAT(Wrong({"estop", "--release", "why"}), HasSubstr("excludes"));
}

TEST(CommandLine, KeepsAStateForATimeOrEndsThat) {
  Parsed({"keep", "Active", "--for", "30"});
  Parsed({"keep", "--end"});
  EXPECT_THAT(Wrong({"keep"}), HasSubstr("expected STATE --for SECONDS, or --end"));
  EXPECT_THAT(Wrong({"keep", "Active"}), HasSubstr("--for"));
  EXPECT_THAT(Wrong({"keep", "Active", "--for", "0"}), HasSubstr("--for"));
  EXPECT_THAT(Wrong({"keep", "Active", "--for", "5", "--end"}), HasSubstr("excludes"));
}

TEST(CommandLine, SwitchesLowPowerOnOrOff) {
  Parsed({"low-power", "on"});
  Parsed({"low-power", "off", "--this-run"});
  EXPECT_THAT(Wrong({"low-power", "maybe"}), HasSubstr("maybe"));
  EXPECT_THAT(Wrong({"low-power"}), HasSubstr("on|off"));
}

TEST(CommandLine, TakesGlobalOptionsBeforeAndAfterTheCommand) {
  EXPECT_TRUE(Parsed({"--json", "status"}).global.json);
  EXPECT_TRUE(Parsed({"status", "--json"}).global.json);
  const GlobalOptions global = Parsed({"status", "--domain", "7", "--transport", "lan", "--timeout",
                                       "0.25", "--color", "never"})
                                   .global;
  EXPECT_EQ(global.domain, 7);
  EXPECT_EQ(global.transport, "lan");
  EXPECT_EQ(global.timeout, Milliseconds(250));
  EXPECT_EQ(global.colour, ColourWhen::kNever);
  EXPECT_EQ(Parsed({"status"}).global.timeout, std::nullopt);
}

TEST(CommandLine, TakesTheNamespaceFromTheEnvironmentUnlessItIsGiven) {
  setenv("MUSHER_NAMESPACE", "dog1", 1);
  const GlobalOptions from_environment = Parsed({"status"}).global;
  const GlobalOptions given = Parsed({"status", "--namespace", "/fleet/dog2"}).global;
  const GlobalOptions none = Parsed({"status", "--namespace", ""}).global;
  unsetenv("MUSHER_NAMESPACE");
  EXPECT_EQ(from_environment.name_space, "dog1");
  EXPECT_FALSE(from_environment.name_space_given);
  EXPECT_EQ(given.name_space, "fleet/dog2");
  EXPECT_TRUE(given.name_space_given);
  EXPECT_EQ(none.name_space, "");
}

TEST(CommandLine, RefusesWhatItDoesNotUnderstand) {
  EXPECT_EQ(
      Wrong({"stop"}),
      "unknown command 'stop'; `musher estop` stops the robot at once, `musher down` ends the "
      "machine; see musher --help")
      << "it suggested `top`";
  EXPECT_THAT(Wrong({"statsu"}), HasSubstr("unknown command 'statsu'; did you mean 'status'?"));
  EXPECT_THAT(Wrong({"set"}), HasSubstr("STATE is required"));
  EXPECT_THAT(Wrong({"set", "a", "b", "c"}), HasSubstr("not expected: c"));
  EXPECT_THAT(Wrong({"status", "--wtach"}), HasSubstr("--wtach"));
  EXPECT_THAT(Wrong({"status", "--domain", "233"}), HasSubstr("--domain"));
  EXPECT_THAT(Wrong({"status", "--transport", "wifi"}), HasSubstr("--transport"));
  EXPECT_THAT(Wrong({"status", "--timeout", "0"}), HasSubstr("--timeout"));
  EXPECT_THAT(Wrong({"status", "--timeout", "nan"}), HasSubstr("--timeout"));
  EXPECT_THAT(Wrong({"status", "--color", "red"}), HasSubstr("--color"));
  EXPECT_THAT(Wrong({"graph", "f", "--format", "png"}), HasSubstr("--format"));
  EXPECT_THAT(Wrong({"completion", "tcsh"}), HasSubstr("tcsh"));
}

TEST(CommandLine, RefusesNamespacesThatRosDoesNotHave) {
  for (const char* wrong : {"a/", "//a", "a//b", "1a", "a b", "a-b", "a/1"}) {
    EXPECT_THAT(Wrong({"status", "--namespace", wrong}), HasSubstr("namespace")) << wrong;
  }
}

TEST(CommandLine, HelpsWithTheProgramAndWithEachCommand) {
  const auto of = [](Words arguments) {
    const auto parsed = Parse(std::move(arguments));
    const auto& end = std::get<ParseEnd>(parsed);
    EXPECT_EQ(end.exit, ExitCode::kDone);
    return end.out;
  };
  EXPECT_THAT(of({"--help"}), HasSubstr("Exit codes: 0 done"));
  for (const char* command :
       {"check", "up", "down", "status", "set", "plan", "history", "graph", "completion"}) {
    EXPECT_THAT(of({"--help"}), HasSubstr(std::string("\n  ") + command + " "));
    EXPECT_THAT(of({command, "--help"}), HasSubstr(std::string("Usage: musher ") + command));
  }
  EXPECT_THAT(of({"--version"}), ::testing::StartsWith("musher "));
}

// The help of a command does not list them.
TEST(CommandLine, PointsFromAMistakeInAGlobalOptionToTheHelpOfTheProgram) {
  EXPECT_THAT(Wrong({"--json", "status", "--domain", "x"}), EndsWith("; see musher --help"));
  EXPECT_THAT(Wrong({"status", "--domain", "233"}), EndsWith("; see musher --help"));
  EXPECT_THAT(Wrong({"status", "--timeout", "0"}), EndsWith("; see musher --help"));
  EXPECT_THAT(
      Wrong({"status", "--namespace", "1a"}),
      ::testing::AllOf(HasSubstr("that begin with no digit"), EndsWith("; see musher --help")));
}

TEST(CommandLine, PointsFromEachMistakeToTheHelpOfItsCommand) {
  EXPECT_THAT(Wrong({"set"}), EndsWith("; see musher set --help"));
  EXPECT_THAT(Wrong({"set", "Active", "--now"}), EndsWith("; see musher set --help"));
  EXPECT_THAT(Wrong({"status", "--follow=x"}), EndsWith("; see musher status --help"));
  EXPECT_THAT(Wrong({"keys", "add"}), EndsWith("; see musher keys add --help"));
  EXPECT_THAT(Wrong({"ota", "bundle", "x"}), EndsWith("; see musher ota bundle --help"));
  EXPECT_EQ(Wrong({"keys"}), "missing command; see musher keys --help");
  EXPECT_EQ(Wrong({"keys", "ad"}),
            "unknown command 'ad'; did you mean 'add'? see musher keys --help");
  EXPECT_EQ(Wrong({"--json"}), "missing command; see musher --help");
  EXPECT_THAT(Wrong({"--wat", "status"}), EndsWith("; see musher status --help"));
}

TEST(CommandLine, GroupsTheCommandsByWhatTheyAreFor) {
  const auto parsed = Parse({"--help"});
  const std::string& help = std::get<ParseEnd>(parsed).out;
  std::size_t at = 0;
  for (const char* line : {"\nPrepare a config:\n  check ", "\n  tree ", "\nStart and stop:\n  up ",
                           "\n  down ", "\nOperate the machine:\n  status ", "\n  set ",
                           "\n  estop ", "\n  skill ", "\nInspect the past:\n  history ",
                           "\nInstall and upgrade:\n  keys ", "\n  ota ", "\n  completion "}) {
    const std::size_t found = help.find(line, at);
    ASSERT_NE(found, std::string::npos) << line << " in " << help;
    at = found;
  }
  EXPECT_THAT(help, Not(HasSubstr("\n  complete ")));
}

TEST(CommandLine, HasAnExampleOfEachCommandThatItUnderstands) {
  for (const std::string& line : GrammarLines()) {
    if (line.starts_with('-')) continue;
    const std::string command = line.substr(0, line.find(' '));
    const auto parsed = Parse({command.c_str(), "--help"});
    const auto* help = std::get_if<ParseEnd>(&parsed);
    if (help == nullptr) continue;  // of another program, which prints its own
    const std::string begin = "\nExample: ";
    const std::size_t at = help->out.find(begin);
    ASSERT_NE(at, std::string::npos) << command << " is added without an example";
    const std::size_t from = at + begin.size();
    const std::string example = help->out.substr(from, help->out.find('\n', from) - from);
    EXPECT_THAT(example, StartsWith("musher " + command)) << "of another command";
    std::istringstream in(example);
    std::vector<std::string> words{std::istream_iterator<std::string>(in), {}};
    Words arguments;
    for (std::size_t i = 1; i < words.size(); ++i) arguments.push_back(words[i].c_str());
    EXPECT_TRUE(std::holds_alternative<CommandLine>(Parse(arguments))) << example;
  }
}

TEST(CommandLine, OffersTheCommandsForAnActuatorWithTheirOptions) {
  for (const Words& line :
       {Words{"logs"},
        Words{"logs", "legs", "eyes", "-f", "-n", "5", "--level", "warning", "--since", "5m"},
        Words{"top", "--once"}, Words{"top", "--interval", "0.5", "--json"},
        Words{"describe", "legs", "--config", "robot.toml"}}) {
    Parsed(line);
  }
  EXPECT_THAT(Wrong({"logs", "--level", "loud"}), HasSubstr("loud"));
  EXPECT_THAT(Wrong({"logs", "--since", "yesterday"}), HasSubstr("invalid time 'yesterday'"));
  EXPECT_THAT(Wrong({"top", "--interval", "0"}), HasSubstr("not between 0.1 and 3600"));
  EXPECT_THAT(Wrong({"describe"}), HasSubstr("ACTUATOR"));
}

TEST(CommandLine, ReportsThatJsonWasRequestedInAWrongCommandLine) {
  EXPECT_TRUE(std::get<ParseEnd>(Parse({"nonsense", "--json"})).json);
  EXPECT_FALSE(std::get<ParseEnd>(Parse({"nonsense"})).json);
}

}  // namespace musher::cli::command_line_test
