#include "musher/wire/dds_options.hpp"

namespace musher::transport {

DdsOptions OptionsFor(const MachineConfig& config, const std::string& identity,
                      const std::string& node_name) {
  DdsOptions options;
  options.profile = config.transport;
  options.credentials = CredentialsFor(config, identity);
  options.node_name = node_name;
  options.name_space = config.name_space;
  options.ros_distro = config.ros_distro;
  return options;
}

std::optional<Credentials> CredentialsFor(const MachineConfig& config,
                                          const std::string& identity) {
  if (config.keys.empty()) return std::nullopt;
  return Credentials{config.keys, identity};
}

}  // namespace musher::transport
