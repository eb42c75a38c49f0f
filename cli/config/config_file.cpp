#include "musher/cli/config/config_file.hpp"

#include "musher/base/toml/file.hpp"
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

bool LoadStableRules(const std::string& file, const MachineConfig& config, Console& console,
                     std::vector<StableRule>& rules) {
  if (file.empty()) return true;
  const Result<std::string> text = config_toml::ReadModuleText(file);
  if (!text) {
    console.Fail(Error{kCodeParametersInvalid, "--rules " + file + ": " + text.error().message});
    return false;
  }
  StableRules read = ReadStableRules(config, file, text.value());
  for (const Diagnostic& d : read.diagnostics) console.Note(FormatDiagnostic(d));
  if (!read.diagnostics.empty() && console.mode().json) {
    console.Print(BadConfigJson(file, read.diagnostics));
  }
  rules = std::move(read.rules);
  return read.diagnostics.empty();
}

}  // namespace musher::cli
