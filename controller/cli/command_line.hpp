#pragma once
// From argv to values: the grammar of `musher` and its help.

#include <string>
#include <variant>

#include "musher/controller/cli/exit_code.hpp"
#include "musher/controller/cli/options.hpp"

namespace musher::cli {

// There is nothing to run: help was asked for, or the command line is wrong.
struct ParseEnd {
  ExitCode exit = ExitCode::kDone;
  std::string out;  // help or version
  std::string err;  // what is wrong; then `json` says that --json was given
  bool json = false;
};

// $MUSHER_NAMESPACE counts where --namespace is missing.
std::variant<CommandLine, ParseEnd> ParseCommandLine(int argc, const char* const* argv);

}  // namespace musher::cli
