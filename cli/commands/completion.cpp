// musher completion bash|zsh|fish: the script that completes its command lines. The same files are
// installed where the shells look for them.

#include <CLI/CLI.hpp>
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/completion_scripts.hpp"
#include "musher/cli/grammar/grammar.hpp"

namespace musher::cli {
namespace {

struct CompletionOptions {
  std::string shell;  // "bash", "zsh" or "fish"
};

ExitCode Completion(const CompletionOptions& options, const GlobalOptions& /*global*/,
                    Console& console) {
  console.Print(options.shell == "zsh"    ? kZshCompletion
                : options.shell == "fish" ? kFishCompletion
                                          : kBashCompletion);
  return ExitCode::kDone;
}

}  // namespace

void AddCompletion(Grammar& grammar) {
  auto [app, options] = grammar.Add("completion", "Print the completion script of a shell",
                                    Completion, "musher completion bash");
  grammar
      .OneOf(app.add_option("SHELL", options.shell, "bash, zsh or fish"), {"bash", "zsh", "fish"})
      ->required();
}

}  // namespace musher::cli
