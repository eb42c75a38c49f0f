#include <cstdlib>
#include <utility>

#include "musher/lifecycle/config/config_toml.hpp"

namespace musher {

Result<MachineConfig> ReadValidConfig(std::string path) {
  if (path.empty()) {
    const char* from_environment = std::getenv("MUSHER_CONFIG");
    if (from_environment == nullptr) {
      return Error{kCodeParametersInvalid, "no state config is named and MUSHER_CONFIG is not set"};
    }
    path = from_environment;
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
