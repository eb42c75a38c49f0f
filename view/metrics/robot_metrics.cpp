#include "musher/view/metrics/robot_metrics.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "musher/lifecycle/event_name.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::view {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostEpochs = 16;
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
  if (entry.id == 0 || !IsNew(entry)) return;  // 0: not a decision, for example of the journal
  if (entry.kind == "switch") return OnSwitch(entry, event);
  if (!entry.actuator.empty()) OnFault(entry, event);
}

bool RobotMetrics::IsNew(const msg::HistoryEntry& entry) {
  const Epoch epoch(entry.epoch);
  const RecordId id(entry.id);
  Mark& mark = marks_[epoch];
  if (id > mark.id && entry.wall_ns >= mark.not_before) {
    mark.id = id;
    mark.wall_ns = std::max(mark.wall_ns, entry.wall_ns);
  } else if (id <= mark.id && entry.wall_ns > mark.wall_ns) {
    // A machine without its disk counts its epochs from the beginning again.
    mark = {id, entry.wall_ns, entry.wall_ns};
  } else {
    return false;
  }
  if (marks_.size() > kMostEpochs) {
    const bool is_lowest = marks_.begin()->first == epoch;
    marks_.erase(is_lowest ? std::next(marks_.begin()) : marks_.begin());
  }
  return true;
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

}  // namespace musher::view
