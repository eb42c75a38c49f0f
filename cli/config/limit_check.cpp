#include "musher/cli/config/limit_check.hpp"

#include <string>

#include "musher/cli/config/config_places.hpp"

namespace musher::cli {

std::vector<Diagnostic> CheckLimits(const MachineConfig& config, const Priorities& user) {
  const ConfigPlaces places(config.file);
  std::vector<Diagnostic> found;
  const auto add = [&](const ActuatorConfig& actuator, const std::string& key,
                       const std::string& most, const std::string& setting) {
    const std::string table = "actuator." + actuator.name;
    const int line = places.LineOf(table, key);
    found.push_back({config.file, line, line == 0 ? 0 : 1, Severity::kError,
                     table + "." + key + ": this user may set " + most +
                         "; start the machine as root, or permit it by " + setting +
                         "= in the unit of the controller"});
  };
  for (const ActuatorConfig& actuator : config.actuators) {
    if (user.any || actuator.command.empty() || !actuator.host.empty()) continue;
    const ProcessLimits& limits = actuator.limits;
    const auto& priority = limits.realtime_priority;
    if (priority && static_cast<std::uint64_t>(*priority) > user.highest_real_time) {
      add(actuator, "realtime_priority", std::to_string(user.highest_real_time) + " at most",
          "LimitRTPRIO");
    }
    if (limits.nice && *limits.nice < user.lowest_nice) {
      add(actuator, "nice", std::to_string(user.lowest_nice) + " at least", "LimitNICE");
    }
  }
  return found;
}

}  // namespace musher::cli
