// A controller that starts finds actuators that run: where the machine goes on from, and whether
// the controller before died during a switch.

#include <algorithm>

#include "musher/lifecycle/decision.hpp"
#include "musher/lifecycle/ros2_states.hpp"

namespace musher {

// The least active state of those that run already, or are on their way to: by going on from there
// a switch that the controller before died in is finished on the way down and undone on the way up.
// One that was set apart says nothing about the machine, unless all are.
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
  bool own_there = false;  // one of Musher's own, which says where it is
  const auto consider_all = [&](bool ros2) {
    for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
      const ActuatorRecord& record = Of(i);
      const bool is_ros2 = ConfigOf(i).protocol == Protocol::kRos2Lifecycle;
      if (record.presence != Presence::kPresent || (record.report.apart && !all_apart)) continue;
      if (is_ros2 != ros2) continue;
      // Where those have not got beyond SetUp and SelfCheck, the machine was starting.
      if (ros2 && lowest && AgreesWith(i, *lowest)) continue;
      if (ros2 && !lowest && own_there && AgreesWith(i, State(kSetUp))) continue;
      own_there |= ConfigOf(i).protocol == Protocol::kMusher;
      // Who is being torn down alone will end, and be started again if it should.
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

// Whether a ROS 2 node is where that state of the machine takes it: then it may have been in that
// state, whatever its link has guessed.
bool Decision::AgreesWith(std::size_t i, const State& state) const {
  const auto& own = ConfigOf(i).ros2_states;
  return config_.RankOf(Of(i).state()) && Ros2GoalOf(own, Of(i).state()) == Ros2GoalOf(own, state);
}

// Whether the controller before died during a switch: an actuator is on a way that does not end
// where the machine is, or comes from above. One that comes up to where the machine is had been
// started again, or was late.
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

// The actuators that are elsewhere than where the machine is, or on the way.
std::string Decision::Elsewhere() const {
  std::string text;
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    const ActuatorRecord& record = Of(i);
    const bool there = record.state() == machine_.state && !record.report.busy();
    if (record.presence != Presence::kPresent || record.held || there) continue;
    text += (text.empty() ? "" : ", ") + ConfigOf(i).name + " in " + record.state() +
            (record.report.busy() ? " on its way to " + record.report.target : "");
  }
  return text;
}

// An earlier controller left actuators running: the machine goes on from the least active state, so
// that nothing becomes more active by a restart; the others follow.
void Decision::AdoptFrom(const State& lowest, std::uint64_t cause) {
  if (lowest == kTearDown) {
    const std::string message =
        "the controller before ended in the middle of TearDown; this one finishes it";
    const std::uint64_t told = RecordMachine(kCodeOk, message, cause);
    Do(action::StartUpEnded{false, message});
    return Stop(MakePlan(config_, machine_, lowest), {}, told);
  }
  machine_.state = lowest;
  if (const std::string elsewhere = Elsewhere(); !elsewhere.empty()) {
    cause = RecordMachine(kCodeOk,
                          FoundSwitching() ? "an earlier controller left a switch half way (" +
                                                 elsewhere + "); it is ended in " + lowest
                                           : "the least active state that is found is " + lowest +
                                                 "; elsewhere: " + elsewhere,
                          cause);
  }
  BecomeRunning("the machine is adopted in " + lowest, cause);
}

}  // namespace musher
