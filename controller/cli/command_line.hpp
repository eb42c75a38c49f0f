#pragma once
// Parses argv: the grammar of `musher` and its help.

#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "musher/controller/cli/console/console.hpp"
#include "musher/controller/cli/console/exit_code.hpp"
#include "musher/controller/cli/console/options.hpp"

namespace musher::cli {

// A command with its own options; prints its result to the console.
using RunCommand = std::function<ExitCode(const GlobalOptions&, Console&)>;

struct CommandLine {
  GlobalOptions global;
  RunCommand run;
};

// No command to run: the caller requested help, or the command line is wrong.
struct ParseEnd {
  ExitCode exit = ExitCode::kDone;
  std::string out;    // help or version
  std::string err;    // what is wrong
  bool json = false;  // with `err`: --json was given
};

// Uses $MUSHER_NAMESPACE if --namespace is missing.
std::variant<CommandLine, ParseEnd> ParseCommandLine(int argc, const char* const* argv);

// Every command with each of its arguments and options, one per line: "up FILE", "up --detach",
// "ota bundle --key"; "--json" and other options of every command stand alone. A test compares
// docs/reference.md with it.
std::vector<std::string> GrammarLines();

}  // namespace musher::cli
