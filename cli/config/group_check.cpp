#include "musher/cli/config/group_check.hpp"

#include "musher/base/own_folder.hpp"
#include "musher/cli/config/config_places.hpp"

namespace musher::cli {

std::vector<Diagnostic> CheckLogGroup(const MachineConfig& config) {
  const std::string& group = config.log_group;
  if (group.empty() || GroupNamed(group)) return {};
  const int line = ConfigPlaces(config.file).LineOf("controller", "log_group");
  return {{config.file, line, line == 0 ? 0 : 1, Severity::kError,
           "controller.log_group: this host has no group '" + group + "'; `sudo groupadd " + group +
               "` makes it"}};
}

}  // namespace musher::cli
