#include "musher/cli/command_line.hpp"

#include <algorithm>
#include <string_view>

#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/complete.hpp"

namespace musher::cli {
namespace {

// `musher` alone and `musher help [COMMAND]` mean --help.
std::vector<const char*> WithHelp(int argc, const char* const* argv) {
  std::vector<const char*> words(argv, argv + argc);
  const bool help = argc > 1 && std::string_view(argv[1]) == "help";
  if (help) words.erase(words.begin() + 1);
  if (help || argc == 1) words.push_back("--help");
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
