#include "musher/controller/cli/command_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

namespace musher::cli::command_line_test {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

std::variant<CommandLine, ParseEnd> Parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "musher");
  return ParseCommandLine(static_cast<int>(arguments.size()), arguments.data());
}

CommandLine Parsed(std::vector<const char*> arguments) {
  auto parsed = Parse(std::move(arguments));
  if (auto* line = std::get_if<CommandLine>(&parsed)) return *line;
  ADD_FAILURE() << std::get<ParseEnd>(parsed).err;
  return {};
}

// The error of a command line that must be wrong.
std::string Wrong(std::vector<const char*> arguments) {
  const auto parsed = Parse(std::move(arguments));
  const auto* end = std::get_if<ParseEnd>(&parsed);
  if (end == nullptr) return "nothing is wrong";
  EXPECT_EQ(end->exit, ExitCode::kUsage);
  EXPECT_EQ(end->out, "");
  return end->err;
}

TEST(CommandLine, GivesTheWordsOfACommand) {
  const auto set = std::get<SetOptions>(Parsed({"set", "Active", "audio"}).command);
  EXPECT_EQ(set.state, "Active");
  EXPECT_EQ(set.actuator, "audio");
  EXPECT_EQ(std::get<SetOptions>(Parsed({"set", "Active"}).command).actuator, "");
  EXPECT_EQ(std::get<CheckOptions>(Parsed({"check", "a", "b"}).command).files,
            (std::vector<std::string>{"a", "b"}));
  EXPECT_TRUE(std::get<UpOptions>(Parsed({"up", "a", "--detach"}).command).detach);
  EXPECT_FALSE(std::get<UpOptions>(Parsed({"up", "a"}).command).takeover);
  EXPECT_TRUE(std::get<UpOptions>(Parsed({"up", "--takeover", "a"}).command).takeover);
  EXPECT_EQ(std::get<RestartOptions>(Parsed({"restart", "audio"}).command).actuator, "audio");
  EXPECT_TRUE(std::get<StatusOptions>(Parsed({"status", "-w"}).command).watch);
  const auto history =
      std::get<HistoryOptions>(Parsed({"history", "--since", "1h", "--limit", "7"}).command);
  EXPECT_EQ(history.since, "1h");
  EXPECT_EQ(history.limit, 7U);
  const auto graph = std::get<GraphOptions>(
      Parsed({"graph", "f", "--what", "actuators", "--format", "svg", "-o", "x"}).command);
  EXPECT_EQ(graph.what, "actuators");
  EXPECT_EQ(graph.format, "svg");
  EXPECT_EQ(graph.output, "x");
}

TEST(CommandLine, EngagesAnEmergencyStopWithAReasonOfAnyWordsOrReleasesIt) {
  EXPECT_TRUE(std::get<EstopOptions>(Parsed({"estop"}).command).reason.empty());
  const auto estop = std::get<EstopOptions>(Parsed({"estop", "it", "smokes"}).command);
  EXPECT_EQ(estop.reason, (std::vector<std::string>{"it", "smokes"}));
  EXPECT_FALSE(estop.release);
  EXPECT_TRUE(std::get<EstopOptions>(Parsed({"estop", "--release"}).command).release);
  EXPECT_THAT(Wrong({"estop", "--release", "why"}), HasSubstr("excludes"));
}

TEST(CommandLine, KeepsAStateForATimeOrEndsThat) {
  const auto keep = std::get<KeepOptions>(Parsed({"keep", "Active", "--for", "30"}).command);
  EXPECT_EQ(keep.state, "Active");
  EXPECT_EQ(keep.seconds, 30);
  EXPECT_FALSE(keep.end);
  EXPECT_TRUE(std::get<KeepOptions>(Parsed({"keep", "--end"}).command).end);
  EXPECT_THAT(Wrong({"keep"}), HasSubstr("expected STATE --for SECONDS, or --end"));
  EXPECT_THAT(Wrong({"keep", "Active"}), HasSubstr("--for"));
  EXPECT_THAT(Wrong({"keep", "Active", "--for", "0"}), HasSubstr("--for"));
  EXPECT_THAT(Wrong({"keep", "Active", "--for", "5", "--end"}), HasSubstr("excludes"));
}

TEST(CommandLine, SwitchesLowPowerOnOrOff) {
  EXPECT_TRUE(std::get<LowPowerOptions>(Parsed({"low-power", "on"}).command).on);
  const auto off = std::get<LowPowerOptions>(Parsed({"low-power", "off", "--this-run"}).command);
  EXPECT_FALSE(off.on);
  EXPECT_TRUE(off.this_run);
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
  EXPECT_THAT(Wrong({"completion", "fish"}), HasSubstr("fish"));
}

TEST(CommandLine, RefusesNamespacesThatRosDoesNotHave) {
  for (const char* wrong : {"a/", "//a", "a//b", "1a", "a b", "a-b", "a/1"}) {
    EXPECT_THAT(Wrong({"status", "--namespace", wrong}), HasSubstr("namespace")) << wrong;
  }
}

TEST(CommandLine, HelpsWithTheProgramAndWithEachCommand) {
  const auto of = [](std::vector<const char*> arguments) {
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

TEST(CommandLine, PointsFromEachMistakeToTheHelpOfItsCommand) {
  EXPECT_THAT(Wrong({"set"}), EndsWith("; see musher set --help"));
  EXPECT_THAT(Wrong({"set", "Active", "--now"}), EndsWith("; see musher set --help"));
  EXPECT_THAT(Wrong({"--json", "status", "--domain", "x"}), EndsWith("; see musher status --help"));
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
  for (const char* line : {"\nPrepare a config:\n  check ", "\nStart and stop:\n  up ", "\n  down ",
                           "\nOperate the machine:\n  status ", "\n  set ", "\n  estop ",
                           "\nInspect the past:\n  history ", "\nInstall and upgrade:\n  keys ",
                           "\n  ota ", "\n  completion "}) {
    const std::size_t found = help.find(line, at);
    ASSERT_NE(found, std::string::npos) << line << " in " << help;
    at = found;
  }
  EXPECT_THAT(help, Not(HasSubstr("\n  complete ")));
}

TEST(CommandLine, ReportsThatJsonWasRequestedInAWrongCommandLine) {
  EXPECT_TRUE(std::get<ParseEnd>(Parse({"nonsense", "--json"})).json);
  EXPECT_FALSE(std::get<ParseEnd>(Parse({"nonsense"})).json);
}

}  // namespace musher::cli::command_line_test
