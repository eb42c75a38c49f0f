#pragma once
// Checks what follows the release of an emergency stop: nothing is switched on that was not
// requested since the last stop.
//
// Invariants: kReleaseSwitchesNothingOn, kNoUnrequestedActivation (of a start that may not read the
// stops of another folder).

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "musher/simulation/subject_checker.hpp"

namespace musher::simulation {

class ReleaseChecker : public SubjectChecker {
 public:
  explicit ReleaseChecker(CheckerContext& context) : SubjectChecker(context) {}

  // What permits a command, noted when the command is sent.
  struct Basis {
    bool requested = true;    // since the last emergency stop that its controller knows
    std::uint64_t order = 0;  // see CheckerContext::order
  };

  // A controller begins to lead; an operator has started it, or a supervisor.
  void OnBegin(const SimulatedController& controller, bool by_supervisor);
  // A controller publishes that a stop is engaged, or released.
  void OnStopPublished(const SimulatedController& controller, const msg::EmergencyStop& stop);
  // A person requests something of the policy; `up`: it may lead to a more active state.
  void OnPolicyRequest(const SimulatedController& controller, bool up) {
    seen_[controller.serial()].requests_up = up;
  }
  void NoteRequest(const SimulatedController& controller, const action::Record& record);
  void NoteLatched(const std::pair<std::string, std::size_t>& actuator,
                   const ActuatorReport& before, const ActuatorReport& report);
  bool IsRequestedSinceStop(std::uint64_t controller, ActuatorIndex i, const State& target);
  void CheckAfterRelease(const std::string& name, std::size_t host, const ActuatorReport& before,
                         const ActuatorReport& report, const Basis& sent);

 private:
  struct Seen {                        // of a controller
    std::uint64_t stop_order = 0;      // when it last engaged a stop, see CheckerContext::order
    std::set<RecordId> requests = {};  // its records of requests
    std::set<RecordId> up = {};        // of them, those that lead up as far as the battery permits
    bool requests_up = false;          // the next record of a request to its policy is one
  };
  struct SinceStop {
    std::uint64_t order = 0;
    std::optional<ActuatorIndex> actuator;  // nullopt: of the machine
    State target;
    bool up = false;  // or on the level, or by a start: it may switch on
  };

  bool TakesNothingOver(const SimulatedController& controller) const;
  void NoteRaised(const Machine& machine, const State& target);
  bool AllSwitchedOnSince(std::uint64_t stopped) const;
  void CheckStart(const SimulatedController& controller, const action::SwitchNote& begun);
  std::uint64_t LastStopOf(std::uint64_t controller);

  std::map<std::uint64_t, Seen> seen_;  // by the serial of the controller
  std::map<std::size_t, std::uint64_t>
      stopped_on_;                     // when a controller of that host engaged a stop
  std::vector<SinceStop> since_stop_;  // requests that led somewhere
  // Controllers that found a folder that they may not read, until a state is requested, by serial.
  std::set<std::uint64_t> unanswered_;
  // When a person started a controller that took nothing over, by its serial.
  std::map<std::uint64_t, std::uint64_t> begun_by_a_person_;
  std::map<StopId, std::uint64_t> release_order_;  // of the stops that are over: when
  std::map<std::pair<std::string, std::size_t>, std::uint64_t> latched_;  // actuator, host: when
};

}  // namespace musher::simulation
