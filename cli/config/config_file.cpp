#include "musher/cli/config/config_file.hpp"

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

}  // namespace musher::cli
