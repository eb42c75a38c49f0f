#pragma once
// Checks that an actuator that a person has set alone stays there, or below, until a person leads
// the machine, or the actuator, elsewhere: over restarts of its process and of the controller on
// that host.
//
// Invariant: kHoldStays.

#include <cstddef>
#include <map>
#include <string>

#include "musher/simulation/process_checker.hpp"

namespace musher::simulation {

class HoldChecker : public SubjectChecker {
 public:
  HoldChecker(CheckerContext& context, const ProcessChecker& processes)
      : SubjectChecker(context), processes_(processes) {}

  void OnBegin(const SimulatedController& controller, Starter starter);
  // After each step of a controller.
  void NoteSwitch(const SimulatedController& controller);
  void OnReply(const SimulatedController& controller, const SwitchResult& result);
  void OnSend(const Machine& machine, const action::SendSwitch& send);

 private:
  struct Hold {
    State in;
    std::uint64_t controller = 0;  // its serial
    std::size_t host = 0;          // of the controller
  };
  // Whether the switch may end the hold.
  bool Ends(const Switch& s, ActuatorIndex i, const State& in) const;

  const ProcessChecker& processes_;
  std::map<std::string, Hold> holds_;  // by actuator
  // By controller: the last number of a switch or a command that was seen.
  std::map<std::uint64_t, CommandNumber> numbers_;
  std::map<std::uint64_t, CommandNumber>
      down_;  // by controller: its last switch of the machine down
};

}  // namespace musher::simulation
