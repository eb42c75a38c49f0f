#include "musher/view/record/trouble.hpp"

namespace musher::view {

std::optional<std::string> TroubleWatch::On(const msg::MachineStatus& status) {
  std::optional<std::string> trouble;
  const auto say = [&trouble](const std::string& what) {
    if (!trouble) trouble = what;
  };
  if (status.emergency_stop && !stopped_) say("emergency-stop");
  if (status.state == "Error" && state_ != "Error") say("error");
  std::map<std::string, std::string> health;
  for (const auto& actuator : status.actuators) {
    const bool lost = actuator.presence == "lost";
    const bool ill =
        !actuator.health.empty() && actuator.health != "well" && actuator.health != "starved";
    const std::string now = ill ? actuator.health : lost ? "lost" : "";
    if (!now.empty() && health_[actuator.name].empty()) say(actuator.name + "-" + now);
    health[actuator.name] = now;
  }
  const std::set<std::string> degraded(status.degraded.begin(), status.degraded.end());
  for (const std::string& name : degraded) {
    if (!degraded_.contains(name)) say(name + "-degraded");
  }
  stopped_ = status.emergency_stop;
  state_ = status.state;
  health_ = std::move(health);
  degraded_ = degraded;
  if (std::exchange(first_, false)) return std::nullopt;
  return trouble;
}

std::optional<std::string> TroubleOf(std::string_view event) {
  if (event == "switch_undone") return "switch-undone";
  if (event == "switch_refused") return "switch-refused";
  return std::nullopt;
}

}  // namespace musher::view
