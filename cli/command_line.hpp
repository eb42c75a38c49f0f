#pragma once
// Parses argv with the grammar of all commands.

#include <string>
#include <variant>
#include <vector>

#include "musher/cli/grammar/grammar.hpp"

namespace musher::cli {

// Uses $MUSHER_NAMESPACE if --namespace is missing.
std::variant<CommandLine, ParseEnd> ParseCommandLine(int argc, const char* const* argv);

// Every command with each of its arguments and options, one per line: "up FILE", "up --detach",
// "ota bundle --key"; "--json" and other options of every command stand alone. A test compares
// docs/reference.md with it.
std::vector<std::string> GrammarLines();

}  // namespace musher::cli
