#include <utility>

#include "musher/lifecycle/config/config_toml.hpp"

namespace musher {

Result<MachineConfig> ReadValidConfig(const std::string& path) {
  if (path.empty()) {
    return Error{kCodeParametersInvalid, "no state config is named and MUSHER_CONFIG is not set"};
  }
  ConfigReading reading = ReadConfigFile(path);
  if (reading.config) return *std::move(reading.config);
  std::string message;
  for (const Diagnostic& diagnostic : reading.diagnostics) {
    if (diagnostic.severity != Severity::kError) continue;
    message += (message.empty() ? "" : "\n") + FormatDiagnostic(diagnostic);
  }
  return Error{kCodeParametersInvalid, message};
}

}  // namespace musher
