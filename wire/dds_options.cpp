#include "musher/wire/dds_options.hpp"

#include <algorithm>
#include <cstddef>

namespace musher::transport {

namespace {

// From so many processes of a controller on, the timing of a crowd is used. Processes of all stages
// count, because a process of a later stage takes even longer to discover the running ones. With 48
// processes the timing of a crowd saves some 15 % of the start, with 100 half of it; but it repeats
// a lost sample later.
constexpr std::ptrdiff_t kCrowd = 64;

bool IsCrowd(const MachineConfig& config) {
  return std::ranges::count_if(config.actuators, [](const ActuatorConfig& actuator) {
           return actuator.protocol == Protocol::kMusher && !actuator.command.empty();
         }) >= kCrowd;
}

}  // namespace

DdsOptions OptionsFor(const MachineConfig& config, const std::string& identity,
                      const std::string& node_name) {
  DdsOptions options;
  options.profile = config.transport;
  options.interfaces = config.interfaces;
  options.controller = identity == kControllerIdentity;
  options.credentials = CredentialsFor(config, identity);
  options.discovery = IsCrowd(config) ? DiscoveryTiming::kCombinedLong : DiscoveryTiming::kCombined;
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
