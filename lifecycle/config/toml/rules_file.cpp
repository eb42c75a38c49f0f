#include <filesystem>

#include "musher/base/toml/file.hpp"
#include "musher/lifecycle/config/config_toml.hpp"

namespace musher {
namespace {

// The machine's loop looks at each after each event.
constexpr std::size_t kMostRules = 1000;

Result<std::string> TextOf(const std::string& file) {
  std::error_code unknown;
  if (std::filesystem::is_fifo(file, unknown)) {
    return Error{kCodeParametersInvalid, "it is a FIFO, whose open waits for a writer"};
  }
  return config_toml::ReadModuleText(file);
}

}  // namespace

UserRulesReading ReadRulesOf(const MachineConfig& config) {
  if (config.rules_file.empty()) return {};
  const Result<std::string> text = TextOf(config.rules_file);
  if (!text) {
    UserRulesReading unread;
    unread.diagnostics.push_back(
        {config.file, 0, 0, Severity::kError,
         "safety.rules: " + config.rules_file + ": " + text.error().message});
    return unread;
  }
  UserRulesReading read = ReadUserRules(config, config.rules_file, text.value());
  const std::size_t rules = read.rules.size();
  if (rules > kMostRules) {
    read.diagnostics.push_back(
        {config.rules_file, 0, 0, Severity::kError,
         std::to_string(rules) + " rules; at most " + std::to_string(kMostRules)});
  }
  return read;
}

}  // namespace musher
