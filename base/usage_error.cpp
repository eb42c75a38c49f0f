#include "musher/base/usage_error.hpp"

#include <CLI/CLI.hpp>

namespace musher {

std::string UsageError(const CLI::App& app, const CLI::Error& error) {
  std::string reason = error.what();
  if (reason == "A subcommand is required") reason = "COMMAND is required";  // as in its help
  return reason + "; see " + app.get_name() + " --help";
}

int EndOfParse(CLI::App& app, const CLI::ParseError& error, int wrong) {
  app.failure_message([](const CLI::App* of, const CLI::Error& what) {
    return of->get_name() + ": " + UsageError(*of, what) + "\n";
  });
  return app.exit(error) == 0 ? 0 : wrong;
}

}  // namespace musher
