#include "musher/view/metrics/robot_metrics.hpp"

#include <algorithm>
#include <chrono>

#include "musher/base/version.hpp"
#include "musher/lifecycle/event_name.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/view/json/json.hpp"

namespace musher::view {
namespace {

constexpr std::size_t kMostBegun = 64;  // one switch of the machine runs at a time
// Of a switch that was refused before it got a number: the history has no target then.
const std::string kUnknownState = "unknown";

std::string TextAt(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

// The position of `name` in `names`, or its size.
template <class Names>
std::size_t IndexIn(const Names& names, std::string_view name) {
  return static_cast<std::size_t>(std::ranges::find(names, name) - std::begin(names));
}

constexpr std::array<std::string_view, 5> kPhases = {"starting", "running", "failed", "stopping",
                                                     "stopped"};
constexpr std::string_view kPresent = "present";

}  // namespace

RobotMetrics::RobotMetrics() {
  for (const std::string_view state : BuiltInStates()) {
    states_.emplace_back(state);
    const bool is_a_target = state != kUninitialized && state != kSetUp;
    if (is_a_target) targets_[std::string(state)];
  }
  targets_[kUnknownState];
}

void RobotMetrics::On(const msg::MachineStatus& status, Time /*now*/) {
  std::vector<Actuator> actuators;
  for (const msg::ActuatorInfo& info : status.actuators) {
    const bool twice = std::ranges::any_of(
        actuators, [&](const Actuator& known) { return known.info.name == info.name; });
    if (twice || info.name.size() > kLongestName || actuators.size() == kMostActuators) {
      ++dropped_actuators_;
      continue;
    }
    Actuator* known = Find(info.name);
    actuators.push_back(known ? std::move(*known) : Actuator{});
    actuators.back().info = info;
    actuators.back().info.state = Know(info.state);
  }
  actuators_ = std::move(actuators);
  status_ = status;
  status_->actuators.clear();
  status_->state = Know(status.state);
  has_controller_ = true;
}

void RobotMetrics::OnControllerLost() {
  has_controller_ = false;
}

void RobotMetrics::On(const msg::HistoryEntry& entry, std::string_view event) {
  if (entry.id == 0) return;  // not a decision, for example of the journal
  if (entry.kind == "switch") return OnSwitch(entry, event);
  if (entry.actuator.empty()) return;
  const bool is_done = event == NameOf(EventName::kCommandDone);
  if (is_done || event == NameOf(EventName::kCommandOverdue)) return OnCommand(entry, is_done);
  OnFault(entry, event);
}

void RobotMetrics::OnSwitch(const msg::HistoryEntry& entry, std::string_view event) {
  const Json data = Json::parse(entry.data, nullptr, false);
  const bool has_note = data.is_object() && data.contains("target");
  std::string outcome = has_note ? TextAt(data, "outcome") : "";
  if (has_note && outcome.empty()) {
    if (begun_.size() == kMostBegun) begun_.erase(begun_.begin());
    begun_[CommandNumber(entry.switch_number)] = entry.wall_ns;
    return;
  }
  if (event == NameOf(EventName::kSwitchRefused)) outcome = "refused";
  const std::size_t index = IndexIn(kOutcomes, outcome);
  if (index == kOutcomes.size()) return;
  if (!entry.actuator.empty()) {
    if (Actuator* actuator = Find(entry.actuator)) {
      ++actuator->switches[index];
    } else {
      ++dropped_actuators_;
    }
    begun_.erase(CommandNumber(entry.switch_number));
    return;
  }
  Target& target = targets_[has_note ? Know(TextAt(data, "target")) : kUnknownState];
  ++target.switches[index];
  const auto begun = begun_.find(CommandNumber(entry.switch_number));
  if (begun == begun_.end()) return;
  const Duration took(entry.wall_ns - begun->second);
  begun_.erase(begun);
  // A wall clock that was set back measures nothing.
  if (took >= Duration::zero()) {
    target.durations.Observe(ToSeconds(took));
  }
}

// Reported as a fault of its actuator, too, without the time that it took: the command counts once.
void RobotMetrics::OnCommand(const msg::HistoryEntry& entry, bool is_done) {
  const Json data = Json::parse(entry.data, nullptr, false);
  const auto arguments = data.is_object() ? data.find("arguments") : data.end();
  if (arguments == data.end() || !arguments->is_object()) return;
  const auto took_ms = arguments->find("took_ms");
  const std::string target = TextAt(*arguments, "target");
  if (took_ms == arguments->end() || !took_ms->is_number() || target.empty()) return;
  Actuator* actuator = Find(entry.actuator);
  if (!actuator) {
    ++dropped_actuators_;
    return;
  }
  if (!is_done) {
    ++actuator->overdue_commands;
    return;
  }
  constexpr double kMsOfSecond = 1000;
  actuator->commands[Know(target)].Observe(std::max(0.0, took_ms->get<double>() / kMsOfSecond));
}

void RobotMetrics::OnFault(const msg::HistoryEntry& entry, std::string_view event) {
  const auto is = [event](EventName name) { return event == NameOf(name); };
  const bool restart = is(EventName::kRestartScheduled) || is(EventName::kRestartRequested);
  // An exit code that prevents the restart is a crash as well.
  const bool crashed = is(EventName::kActuatorCrashed) || is(EventName::kRestartPrevented);
  const bool well = is(EventName::kActuatorPresent) || is(EventName::kActuatorRecovered);
  std::string_view verdict = crashed                               ? "crashed"
                             : is(EventName::kActuatorHung)        ? "hung"
                             : is(EventName::kActuatorStarved)     ? "starved"
                             : is(EventName::kActuatorPartitioned) ? "partitioned"
                                                                   : "";
  if (!restart && !well && verdict.empty()) return;
  Actuator* actuator = Find(entry.actuator);
  if (!actuator) {
    ++dropped_actuators_;
    return;
  }
  if (restart) ++actuator->restarts;
  if (well) actuator->hung = false;
  const bool end_of_the_hung = crashed && std::exchange(actuator->hung, false);
  if (verdict.empty() || end_of_the_hung) return;
  ++actuator->faults[IndexIn(kHealths, verdict)];
  actuator->hung = verdict == "hung";
}

void RobotMetrics::On(const msg::ActuatorHeartbeat& heartbeat, Time now) {
  if (!status_) return;
  Actuator* actuator = Find(heartbeat.name);
  if (!actuator) {
    ++dropped_actuators_;
    return;
  }
  actuator->heartbeat =
      Heartbeat{now, Duration(std::clamp<std::int64_t>(heartbeat.period_ns, 0, kFarthestNs))};
}

void RobotMetrics::OnProcess(std::string_view name, const std::optional<ProcessUsage>& usage) {
  Actuator* actuator = Find(name);
  if (!actuator) return;
  const auto before = std::exchange(actuator->usage, usage);
  if (!usage || !before) return;  // the time before the first look does not count
  const bool same = before->pid == usage->pid && before->start_time == usage->start_time;
  actuator->cpu_seconds += std::max(0.0, usage->cpu_seconds - (same ? before->cpu_seconds : 0));
}

void RobotMetrics::OnScrape(bool complete) {
  ++scrapes_;
  if (!complete) ++incomplete_scrapes_;
}

RobotMetrics::Actuator* RobotMetrics::Find(std::string_view name) {
  const auto found = std::ranges::find(
      actuators_, name,
      [](const Actuator& actuator) -> std::string_view { return actuator.info.name; });
  return found == actuators_.end() ? nullptr : &*found;
}

const std::string& RobotMetrics::Know(const std::string& state) {
  const auto known = std::ranges::find(states_, state);
  if (known != states_.end()) return *known;
  const bool room = states_.size() < BuiltInStates().size() + kMostStates;
  if (state.empty() || state.size() > kLongestName || !room) {
    ++dropped_states_;
    return kUnknownState;
  }
  targets_[state];
  return states_.emplace_back(state);
}

// --- the families of a robot, in the order in which they are written ---

std::string RobotMetrics::Text(Time now, MetricsFormat format) const {
  Exposition text(format);
  WriteMachine(text);
  WriteSwitches(text);
  WriteCommands(text);
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

void RobotMetrics::WriteCommands(Exposition& text) const {
  text.BeginHistogram({"musher_command_duration_seconds",
                       "Time from a command to an actuator until it was done, by the controller's "
                       "clock, since musher-view began.",
                       "seconds"});
  for (const Actuator& actuator : actuators_) {
    for (const auto& [target, durations] : actuator.commands) {
      text.AddHistogram(durations, {{"actuator", actuator.info.name}, {"target", target}});
    }
  }
  text.BeginCounter({"musher_commands_overdue",
                     "Commands that were not done within their limit, since musher-view began."});
  for (const Actuator& actuator : actuators_) {
    text.Add(actuator.overdue_commands, {{"actuator", actuator.info.name}});
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
