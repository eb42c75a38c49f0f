#include "musher/cli/config/config_file.hpp"

#include <filesystem>

#include "musher/base/toml/file.hpp"
#include "musher/cli/config/config_places.hpp"
#include "musher/cli/console/error_json.hpp"
#include "musher/cyberdog/voice_policy.hpp"  // reads [policy.voice], also where no controller runs
#include "musher/lifecycle/config/config_toml.hpp"

namespace musher::cli {

std::optional<MachineConfig> LoadConfig(const std::string& file, Console& console) {
  ConfigReading reading = ReadConfigFile(file);
  for (const Diagnostic& d : reading.diagnostics) console.Note(FormatDiagnostic(d));
  if (!reading.config && console.mode().json) {
    console.Print(BadConfigJson(file, reading.diagnostics));
  }
  return std::move(reading.config);
}

UserRulesReading RulesOf(const MachineConfig& config) {
  UserRulesReading read = ReadRulesOf(config);
  for (Diagnostic& d : read.diagnostics) {
    if (d.line != 0 || d.file != config.file) continue;
    d.line = ConfigPlaces(config.file).LineOf("safety", "rules");
    d.column = d.line == 0 ? 0 : 1;
  }
  return read;
}

std::string RulesBelow(const MachineConfig& config, const std::string& folder) {
  namespace fs = std::filesystem;
  if (config.rules_file.empty()) return {};
  const fs::path from = fs::absolute(folder).lexically_normal();
  const fs::path inside = fs::path(config.rules_file).lexically_normal().lexically_relative(from);
  return inside.empty() || *inside.begin() == ".." ? "" : inside.string();
}

bool LoadUserRules(const std::string& file, const MachineConfig& config, Console& console,
                   UserRules& rules) {
  UserRulesReading read;
  if (file.empty()) {
    read = RulesOf(config);
  } else {
    const Result<std::string> text = config_toml::ReadModuleText(file);
    if (!text) {
      console.Fail(Error{kCodeParametersInvalid, "--rules " + file + ": " + text.error().message});
      return false;
    }
    read = ReadUserRules(config, file, text.value());
  }
  for (const Diagnostic& d : read.diagnostics) console.Note(FormatDiagnostic(d));
  if (!read.diagnostics.empty() && console.mode().json) {
    console.Print(BadConfigJson(read.diagnostics.front().file, read.diagnostics));
  }
  rules = std::move(read.rules);
  return read.diagnostics.empty();
}

}  // namespace musher::cli
