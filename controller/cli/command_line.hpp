#pragma once
// From argv to values: the grammar of `musher` and its help.

#include <string>
#include <variant>
#include <vector>

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

// Every command with each of its arguments and options, a line for each: "up FILE", "up --detach",
// "ota bundle --key"; "--json" and the like belong to every command. For what is compared with it.
std::vector<std::string> GrammarLines();

}  // namespace musher::cli
