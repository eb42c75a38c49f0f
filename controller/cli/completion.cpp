// musher completion bash|zsh: the script that completes its command lines. The same files are
// installed where the shells look for them.

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/completion_scripts.hpp"

namespace musher::cli {

ExitCode Completion(const CompletionOptions& options, Console& console) {
  console.Print(options.shell == "zsh" ? kZshCompletion : kBashCompletion);
  return ExitCode::kDone;
}

}  // namespace musher::cli
