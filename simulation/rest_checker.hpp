#pragma once
// Says what is under way, and checks the places of the actuators in a stable state.
//
// Invariants: kStatesAgree, kEmergencyStopHolds (in a stable state), kSafeWithoutCritical,
// kOnLostCoversLoss.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "musher/simulation/subject_checker.hpp"

namespace musher::simulation {

class RestChecker : public SubjectChecker {
 public:
  explicit RestChecker(CheckerContext& context)
      : SubjectChecker(context), lost_at_(config_.actuators.size()) {}

  std::string PendingActivity() const;  // what is under way; empty: nothing

  // Call after each step of a controller.
  void NotePresence(const SimulatedController& controller);
  // A switch that an operator or a client requested of the controller has ended in its target.
  void NoteRequestedState(std::uint64_t controller) {
    requested_state_at_ = seen_[controller].requested_state_at = robot_.age();
  }

  void CheckPlace(const Machine& machine, ActuatorIndex i);
  void CheckPlaceInStart(const Machine& machine, ActuatorIndex i);
  void CheckLoss(const Machine& machine, ActuatorIndex i, bool provided);

 private:
  // As for all controllers below: those of before its start, then its own.
  struct Seen {
    PerActuator<Duration> lost_at;
    Duration requested_state_at{};
  };

  std::map<std::uint64_t, Seen> seen_;  // by the serial of the controller
  PerActuator<Duration> lost_at_;       // when each actuator was available for the last time
  Duration requested_state_at_{};  // when an operator's switch last ended in the requested state
};

}  // namespace musher::simulation
