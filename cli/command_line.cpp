#include "musher/cli/command_line.hpp"

#include <algorithm>
#include <string_view>

#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/complete.hpp"

namespace musher::cli {
namespace {

// Of `musher` alone: a screen that leads on.
constexpr const char* kFirstScreen = R"(musher drives a robot's processes between states.

A new robot
  musher new robot rover           a folder with a config; `musher new module arm` for a module
  musher check robot.toml          every error of the config, with its place
  musher up robot.toml             start it; --detach returns once it is up

A robot that runs
  musher status                    the machine and its actuators; --failed, --follow
  musher set LowPower              switch it; `musher plan LowPower` only shows what would happen
  musher estop                     stop it now; `musher down` shuts it down
  musher view                      in a browser

What went wrong
  musher history --why             why it is as it is, and what failed last
  musher describe ACTUATOR         all that is known of one; `musher logs ACTUATOR` its log
  musher doctor                    this computer: network, clocks, limits

musher help            all commands and options
musher COMMAND --help  one command
)";

// `musher help [COMMAND]` means --help.
std::vector<const char*> WithHelp(int argc, const char* const* argv) {
  std::vector<const char*> words(argv, argv + argc);
  const bool help = argc > 1 && std::string_view(argv[1]) == "help";
  if (!help) return words;
  words.erase(words.begin() + 1);
  words.push_back("--help");
  return words;
}

}  // namespace

std::variant<CommandLine, ParseEnd> ParseCommandLine(int argc, const char* const* argv) {
  Grammar grammar;
  AddCommands(grammar);
  if (argc > 1 && std::string_view(argv[1]) == "complete") {
    const auto [global, offer] = grammar.Complete({argv + 2, argv + argc});
    return CommandLine{global, [offer = offer](const GlobalOptions& given, Console& console) {
                         return Complete(offer, given, console);
                       }};
  }
  if (argc == 1) return ParseEnd{ExitCode::kDone, kFirstScreen, "", false};
  const auto words = WithHelp(argc, argv);
  auto parsed = grammar.Parse(static_cast<int>(words.size()), words.data());
  if (auto* end = std::get_if<ParseEnd>(&parsed)) {
    // The parser may have stopped before --json.
    end->json = std::find(argv, argv + argc, std::string_view("--json")) != argv + argc;
  }
  return parsed;
}

std::vector<std::string> GrammarLines() {
  Grammar grammar;
  AddCommands(grammar);
  return grammar.Lines();
}

}  // namespace musher::cli
