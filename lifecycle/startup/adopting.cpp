// A starting controller finds running actuators: the state from which the machine continues, and
// whether the previous controller crashed during a switch.

#include <algorithm>

#include "musher/lifecycle/decision.hpp"
#include "musher/lifecycle/ros2/ros2_states.hpp"

namespace musher {

// The least active state of the running actuators, or of the targets they are switching to.
// Continuing from there finishes a downward switch in which the previous controller crashed, and
// undoes an upward one. A detached actuator says nothing about the machine, unless all are
// detached.
std::optional<State> Decision::LowestFound() const {
  const bool all_apart = std::all_of(
      machine_.actuators.begin(), machine_.actuators.end(), [](const ActuatorRecord& record) {
        return record.presence != Presence::kPresent || record.report.apart;
      });
  std::optional<State> lowest;
  const auto consider = [&](const State& state) {
    const auto rank = config_.RankOf(state);
    if (rank && (!lowest || *rank < *config_.RankOf(*lowest))) lowest = state;
  };
  bool musher_present = false;  // a Musher actuator, which reports its state
  const auto consider_all = [&](bool ros2) {
    for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
      const ActuatorRecord& record = Of(i);
      const bool is_ros2 = ConfigOf(i).protocol == Protocol::kRos2Lifecycle;
      if (record.presence != Presence::kPresent || (record.report.apart && !all_apart)) continue;
      if (is_ros2 != ros2) continue;
      // While the Musher actuators are still in SetUp or SelfCheck, the machine was starting.
      if (ros2 && lowest && AgreesWith(i, *lowest)) continue;
      if (ros2 && !lowest && musher_present && AgreesWith(i, State(kSetUp))) continue;
      musher_present |= ConfigOf(i).protocol == Protocol::kMusher;
      // An actuator that is being torn down alone will exit, and is restarted if it should be.
      const bool ends = record.state() == kTearDown || record.report.target == kTearDown;
      if (ends && record.report.apart) continue;
      consider(record.state());
      consider(record.report.target);  // also out of a check, which has no rank of its own
    }
  };
  consider_all(false);
  consider_all(true);
  return lowest;
}

// Whether a ROS 2 node is in the ROS 2 state to which `state` maps: then it may have been in that
// state of the machine, independent of the state that its link has guessed.
bool Decision::AgreesWith(std::size_t i, const State& state) const {
  const auto& own = ConfigOf(i).ros2_states;
  return config_.RankOf(Of(i).state()) && Ros2GoalOf(own, Of(i).state()) == Ros2GoalOf(own, state);
}

// Whether the previous controller crashed during a switch: an actuator is switching to another
// state than the machine's, or comes down to it. One that comes up to the state of the machine was
// restarted, or was late.
bool Decision::FoundSwitching() const {
  const auto rank = config_.RankOf(machine_.state);
  return std::any_of(
      machine_.actuators.begin(), machine_.actuators.end(), [&](const ActuatorRecord& record) {
        const ActuatorReport& report = record.report;
        if (record.presence != Presence::kPresent || record.held || report.busy_number == 0) {
          return false;
        }
        const auto from = config_.RankOf(report.state);
        return config_.RankOf(report.target) && (report.target != machine_.state || from > rank);
      });
}

// The actuators that are in another state than the machine, or switching.
std::string Decision::Elsewhere() const {
  std::string text;
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    const ActuatorRecord& record = Of(i);
    const bool there = record.state() == machine_.state && !record.report.busy();
    if (record.presence != Presence::kPresent || record.held || there) continue;
    text += (text.empty() ? "" : ", ") + ConfigOf(i).name + " in " + record.state() +
            (record.report.busy() ? " switching to " + record.report.target : "");
  }
  return text;
}

// An earlier controller left actuators running: the machine continues from the least active state,
// so that no actuator becomes more active by a restart; the others are driven there.
void Decision::AdoptFrom(const State& lowest, std::uint64_t cause) {
  if (lowest == kTearDown) {
    const std::string message =
        "the previous controller ended during TearDown; this one finishes it";
    const std::uint64_t recorded = RecordMachine(kCodeOk, message, cause);
    Do(action::StartUpEnded{false, message});
    return Stop(MakePlan(config_, machine_, lowest), {}, recorded);
  }
  machine_.state = lowest;
  if (const std::string elsewhere = Elsewhere(); !elsewhere.empty()) {
    cause = RecordMachine(kCodeOk,
                          FoundSwitching() ? "a previous controller left a switch unfinished (" +
                                                 elsewhere + "); finishing it in " + lowest
                                           : "the least active state found is " + lowest +
                                                 "; elsewhere: " + elsewhere,
                          cause);
  }
  BecomeRunning("the machine is adopted in " + lowest, cause);
}

}  // namespace musher
