// The families of a robot, in the order in which they are written.

#include <chrono>

#include "musher/base/version.hpp"
#include "musher/view/metrics/robot_metrics.hpp"

namespace musher::view {
namespace {

constexpr std::array<std::string_view, 5> kPhases = {"starting", "running", "failed", "stopping",
                                                     "stopped"};
constexpr std::string_view kPresent = "present";

}  // namespace

std::string RobotMetrics::Text(Time now, MetricsFormat format) const {
  Exposition text(format);
  WriteMachine(text);
  WriteSwitches(text);
  WriteStates(text);
  WriteFaults(text);
  WriteHeartbeats(text, now);
  WriteProcesses(text);
  WriteView(text);
  return std::move(text).Finish();
}

std::vector<std::string_view> RobotMetrics::States() const {
  return {states_.begin(), states_.end()};
}

void RobotMetrics::WriteMachine(Exposition& text) const {
  const bool known = has_controller_ && status_;
  text.BeginGauge({"musher_controller_up", "1 if musher-view receives a controller's status."});
  text.Add(known);
  text.BeginInfo({"musher_machine", "The machine that the controller leads."});
  if (known) {
    text.Add(true, {{"machine", status_->machine},
                    {"namespace", status_->name_space},
                    {"config_hash", status_->config_hash},
                    {"version", Version()}});
  }
  text.BeginStateSet({"musher_machine_state", "The state of the machine."});
  if (known) text.AddStates(States(), status_->state);
  text.BeginStateSet({"musher_machine_phase", "The phase of the controller's work."});
  if (known) text.AddStates(kPhases, status_->phase);
  text.BeginGauge({"musher_switch_under_way", "1 while the machine switches to another state."});
  if (known) text.Add(!status_->target.empty());
  text.BeginGauge({"musher_controller_epoch",
                   "Number of the controller's start, which grows with every start."});
  if (known) text.Add(status_->epoch);
  text.BeginGauge({"musher_emergency_stop", "1 while an emergency stop is engaged."});
  if (known) text.Add(status_->emergency_stop);
  text.BeginGauge({"musher_battery_ratio",
                   "Battery charge from 0 to 1; missing where the policy has none.", "ratio"});
  const bool has_battery = known && status_->policy.active && status_->policy.battery >= 0;
  if (has_battery) text.Add(status_->policy.battery / 100.0);
  text.BeginGauge({"musher_battery_charging", "1 while the battery is charged."});
  if (has_battery) text.Add(status_->policy.charging);
  text.BeginGauge({"musher_battery_silent",
                   "1 if no battery status was received for a while; the last value counts."});
  if (has_battery) text.Add(status_->policy.battery_silent);
}

void RobotMetrics::WriteSwitches(Exposition& text) const {
  text.BeginCounter({"musher_switches",
                     "Switches of the machine that ended, since musher-view began. Target unknown: "
                     "refused before it began, which the history records without the target."});
  for (const auto& [name, target] : targets_) {
    for (std::size_t i = 0; i < kOutcomes.size(); ++i) {
      text.Add(target.switches[i], {{"target", name}, {"outcome", kOutcomes[i]}});
    }
  }
  text.BeginHistogram({"musher_switch_duration_seconds",
                       "Time from begin to end of the machine's switches, since musher-view began.",
                       "seconds"});
  for (const auto& [name, target] : targets_) {
    if (target.durations.count() > 0) text.AddHistogram(target.durations, {{"target", name}});
  }
  text.BeginCounter({"musher_actuator_switches",
                     "Switches of one actuator alone that ended, since musher-view began."});
  for (const Actuator& actuator : actuators_) {
    for (std::size_t i = 0; i < kOutcomes.size(); ++i) {
      text.Add(actuator.switches[i], {{"actuator", actuator.info.name}, {"outcome", kOutcomes[i]}});
    }
  }
}

void RobotMetrics::WriteStates(Exposition& text) const {
  static const std::vector<Actuator> none;
  const std::vector<Actuator>& actuators = has_controller_ ? actuators_ : none;
  const std::vector<std::string_view> states = States();
  text.BeginStateSet({"musher_actuator_state", "The state of the actuator."});
  for (const Actuator& actuator : actuators) {
    text.AddStates(states, actuator.info.state, {{"actuator", actuator.info.name}});
  }
  text.BeginGauge({"musher_actuator_present", "1 if the actuator runs and answers."});
  for (const Actuator& actuator : actuators) {
    text.Add(actuator.info.presence == kPresent, {{"actuator", actuator.info.name}});
  }
  text.BeginStateSet({"musher_actuator_health", "The controller's verdict about the actuator."});
  for (const Actuator& actuator : actuators) {
    text.AddStates(kHealths, actuator.info.health, {{"actuator", actuator.info.name}});
  }
  text.BeginGauge({"musher_actuator_degraded",
                   "1 if the actuator is not in the machine's state or a part does not work."});
  for (const Actuator& actuator : actuators) {
    text.Add(actuator.info.degraded, {{"actuator", actuator.info.name}});
  }
  text.BeginGauge({"musher_actuator_critical",
                   "1 if the machine does not become Active without the actuator."});
  for (const Actuator& actuator : actuators) {
    text.Add(actuator.info.critical, {{"actuator", actuator.info.name}});
  }
}

void RobotMetrics::WriteFaults(Exposition& text) const {
  text.BeginCounter({"musher_actuator_restarts",
                     "Restarts of the actuator's process, by its restart policy or by request, "
                     "since musher-view began."});
  for (const Actuator& actuator : actuators_) {
    text.Add(actuator.restarts, {{"actuator", actuator.info.name}});
  }
  text.BeginCounter(
      {"musher_actuator_faults", "Faults by the controller's verdict, since musher-view began."});
  for (const Actuator& actuator : actuators_) {
    for (std::size_t i = 1; i < kHealths.size(); ++i) {  // without "well"
      text.Add(actuator.faults[i], {{"actuator", actuator.info.name}, {"verdict", kHealths[i]}});
    }
  }
}

void RobotMetrics::WriteHeartbeats(Exposition& text, Time now) const {
  const auto has_heartbeat = [](const Actuator& actuator) {
    return actuator.heartbeat && actuator.info.presence == kPresent;
  };
  text.BeginGauge({"musher_actuator_heartbeat_age_seconds",
                   "Time since the last heartbeat that musher-view received, of an actuator that "
                   "is present.",
                   "seconds"});
  for (const Actuator& actuator : actuators_) {
    if (!has_heartbeat(actuator)) continue;
    text.Add(ToSeconds(now - actuator.heartbeat->received), {{"actuator", actuator.info.name}});
  }
  text.BeginGauge({"musher_actuator_heartbeat_period_seconds",
                   "Period of the heartbeats, as the last one gives it.", "seconds"});
  for (const Actuator& actuator : actuators_) {
    if (!has_heartbeat(actuator)) continue;
    text.Add(ToSeconds(actuator.heartbeat->period), {{"actuator", actuator.info.name}});
  }
}

void RobotMetrics::WriteProcesses(Exposition& text) const {
  text.BeginCounter({"musher_actuator_cpu_seconds",
                     "CPU time of the actuator's process on this host, without child processes, "
                     "since the first scrape. Actuators of one process have the same.",
                     "seconds"});
  for (const Actuator& actuator : actuators_) {
    if (actuator.usage) text.Add(actuator.cpu_seconds, {{"actuator", actuator.info.name}});
  }
  text.BeginGauge({"musher_actuator_resident_memory_bytes",
                   "Resident memory of the actuator's process on this host. Actuators of one "
                   "process have the same.",
                   "bytes"});
  for (const Actuator& actuator : actuators_) {
    if (actuator.usage) {
      text.Add(actuator.usage->resident_bytes, {{"actuator", actuator.info.name}});
    }
  }
}

void RobotMetrics::WriteView(Exposition& text) const {
  text.BeginCounter({"musher_dds_lost_samples",
                     "Samples that the readers of musher-view have lost, since it began."});
  text.Add(lost_samples_);
  text.BeginGauge({"musher_view_clients", "Connections of people who look at the robot."});
  text.Add(std::uint64_t{clients_.first}, {{"kind", "page"}});
  text.Add(std::uint64_t{clients_.second}, {{"kind", "foxglove"}});
  text.BeginCounter({"musher_scrapes",
                     "Answers to GET /metrics, with this one, since "
                     "musher-view began."});
  text.Add(scrapes_);
  text.BeginCounter({"musher_scrapes_incomplete",
                     "Those without the newest history: the controller did not answer in time. A "
                     "later one makes up for it."});
  text.Add(incomplete_scrapes_);
  text.BeginCounter({"musher_dropped_names",
                     "Names that have no time series, because they are unknown, too long or too "
                     "many, since musher-view began."});
  text.Add(dropped_actuators_, {{"kind", "actuator"}});
  text.Add(dropped_states_, {{"kind", "state"}});
}

}  // namespace musher::view
