#pragma once
// The names with which a word of the command line can be completed: of the running machine, of a
// config, of files.

#include "musher/cli/console/console.hpp"
#include "musher/cli/grammar/grammar.hpp"

namespace musher::cli {

// `musher complete WORD...`, which the installed scripts call: prints the completions, one per line
// with its meaning.
ExitCode Complete(const CompleteOptions& options, const GlobalOptions& global, Console& console);

}  // namespace musher::cli
