#pragma once
// What a program says of a command line that it cannot take: one line, with its name and where its
// help is. For the main thread of a program, before it does anything else.

#include <string>

namespace CLI {
class App;
class Error;
class ParseError;
}  // namespace CLI

namespace musher {

// Why the command line cannot be taken, and which help says what can.
std::string UsageError(const CLI::App& app, const CLI::Error& error);

// Prints what was asked for (help, version), or the error. Returns the exit code: 0, or `wrong`.
int EndOfParse(CLI::App& app, const CLI::ParseError& error, int wrong);

}  // namespace musher
