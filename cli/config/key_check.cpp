#include "musher/cli/config/key_check.hpp"

#include <set>

#include "musher/cli/config/config_places.hpp"
#include "musher/transport/security/check.hpp"
#include "musher/wire/dds_options.hpp"

namespace musher::cli {

std::vector<std::string> KeyedIdentities(const MachineConfig& config) {
  if (config.keys.empty()) return {};
  std::vector<std::string> identities = {transport::kControllerIdentity};
  for (const ActuatorConfig& actuator : config.actuators) {
    const bool needs_keys = !actuator.command.empty() && actuator.protocol == Protocol::kMusher;
    if (needs_keys) identities.push_back(actuator.name);
  }
  return identities;
}

std::vector<Diagnostic> CheckKeys(const MachineConfig& config) {
  const ConfigPlaces places(config.file);
  const transport::keys::KeyFolder folder(config.keys);
  std::vector<Diagnostic> found;
  std::set<std::string> said;  // an error of the folder is that of every identity
  for (const std::string& identity : KeyedIdentities(config)) {
    const auto until =
        transport::keys::Check(folder, identity, transport::keys::KeyUse::kByAnyProcess);
    if (until || !said.insert(until.error().message).second) continue;
    const int line = places.LineOf("security", "keys");
    found.push_back({config.file, line, line == 0 ? 0 : 1, Severity::kWarning,
                     "in 'security': 'keys': " + until.error().message});
  }
  return found;
}

}  // namespace musher::cli
