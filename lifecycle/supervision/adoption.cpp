#include "musher/lifecycle/supervision/adoption.hpp"

#include <algorithm>
#include <tuple>
#include <vector>

#include "musher/lifecycle/config/ros2_states.hpp"

namespace musher {

// The least active state of the running actuators, or of the targets they are switching to.
// Continuing from there finishes a downward switch in which the previous controller crashed, and
// undoes an upward one. A detached actuator says nothing about the machine, unless all are
// detached.
std::optional<State> Adoption::LowestFound() const {
  const bool all_detached =
      std::all_of(view_.actuators.begin(), view_.actuators.end(), [](const KnownActuator& known) {
        return known.presence != Presence::kPresent || known.report.detached || known.held;
      });
  std::vector<Found> found;
  const auto consider = [&](ActuatorIndex i, const State& state) {
    if (config_.RankOf(state)) found.push_back({i, state});
  };
  bool musher_present = false;  // a Musher actuator, which reports its state
  const auto consider_all = [&](bool ros2) {
    for (const ActuatorIndex i : view_.actuators.Indices()) {
      const KnownActuator& known = Of(i);
      const bool is_ros2 = ConfigOf(i).protocol == Protocol::kRos2Lifecycle;
      const bool detached = known.report.detached || known.held;
      if (known.presence != Presence::kPresent || (detached && !all_detached)) continue;
      if (is_ros2 != ros2) continue;
      // While the Musher actuators are still in SetUp or SelfCheck, the machine was starting.
      if (ros2 && !found.empty() && AgreesWith(i, Lowest(found))) continue;
      if (ros2 && found.empty() && musher_present && AgreesWith(i, State(kSetUp))) continue;
      musher_present |= ConfigOf(i).protocol == Protocol::kMusher;
      // An actuator that is being torn down alone will exit, and is restarted if it should be.
      const bool ends = known.state() == kTearDown || known.report.target == kTearDown;
      if (ends && known.report.detached) continue;
      consider(i, known.state());
      // Also out of a check, which has no rank of its own. On the same level the state counts.
      const State& target = known.report.target;
      if (config_.RankOf(target) != config_.RankOf(known.state())) consider(i, target);
    }
  };
  consider_all(false);
  consider_all(true);
  if (found.empty()) return std::nullopt;
  return Lowest(found);
}

// The least active of `found`. Of several states on the same level: the state with most actuators
// that list all of these states; then with most actuators; then the first in the config.
State Adoption::Lowest(const std::vector<Found>& found) const {
  const auto votes = [&](const State& state) {
    const auto rank = config_.RankOf(state);
    return std::ranges::count_if(found, [&](const Found& one) {
      return one.state == state && std::ranges::all_of(found, [&](const Found& other) {
               return config_.RankOf(other.state) != rank ||
                      ConfigOf(one.actuator).Lists(other.state);
             });
    });
  };
  const auto key = [&](const Found& one) {
    return std::tuple(*config_.RankOf(one.state), -votes(one.state),
                      -std::ranges::count(found, one.state, &Found::state),
                      std::ranges::find(config_.states, one.state));
  };
  return std::ranges::min_element(found, {}, key)->state;
}

// Whether a ROS 2 node is in the ROS 2 state to which `state` maps: then it may have been in that
// state of the machine, independent of the state that its link has guessed.
bool Adoption::AgreesWith(ActuatorIndex i, const State& state) const {
  const auto& own = ConfigOf(i).ros2_states;
  return config_.RankOf(Of(i).state()) && Ros2GoalOf(own, Of(i).state()) == Ros2GoalOf(own, state);
}

// Whether the previous controller was tearing the machine down. The state of a ROS 2 node is a
// guess of its link, for which the others count as well.
bool Adoption::FoundTearDown() const {
  return std::ranges::any_of(view_.actuators.Indices(), [this](ActuatorIndex i) {
    const KnownActuator& known = Of(i);
    return known.presence == Presence::kPresent && !known.report.detached &&
           ConfigOf(i).protocol == Protocol::kMusher &&
           (known.state() == kTearDown || known.report.target == kTearDown);
  });
}

bool Adoption::FoundInSelfCheck() const {
  return std::ranges::any_of(view_.actuators, [](const KnownActuator& known) {
    return known.presence == Presence::kPresent && !known.report.detached &&
           known.state() == kSelfCheck;
  });
}

// Whether the previous controller crashed during a switch: an actuator is switching to another
// state than the machine's, comes down to it, or runs its callback again, as in a rollback. An
// actuator that comes up to the state of the machine was restarted, or was late.
bool Adoption::FoundSwitching() const {
  const auto rank = config_.RankOf(view_.state);
  return std::any_of(
      view_.actuators.begin(), view_.actuators.end(), [&](const KnownActuator& known) {
        const ActuatorReport& report = known.report;
        if (known.presence != Presence::kPresent || known.held || report.busy_number == 0) {
          return false;
        }
        const auto from = config_.RankOf(report.state);
        return config_.RankOf(report.target) && (report.target != view_.state || from >= rank);
      });
}

std::string Adoption::Elsewhere() const {
  std::string text;
  for (const ActuatorIndex i : view_.actuators.Indices()) {
    const KnownActuator& known = Of(i);
    const bool there = known.state() == view_.state && !known.report.busy();
    if (known.presence != Presence::kPresent || known.held || there) continue;
    text += (text.empty() ? "" : ", ") + ConfigOf(i).name + " in " + known.state() +
            (known.report.busy() ? " switching to " + known.report.target : "");
  }
  return text;
}

}  // namespace musher
