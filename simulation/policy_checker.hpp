#pragma once
// Checks the policy by the samples of the battery alone, not by the level that the controller
// derives from them, and by the records of its decisions.
//
// Invariants: kWithinBattery, kNoFlapping, kRaisedAfterQuiet, kNotOffByOneSample, kPowerOffInTime.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "musher/simulation/subject_checker.hpp"

namespace musher::simulation {

class PolicyChecker : public SubjectChecker {
 public:
  explicit PolicyChecker(CheckerContext& context) : SubjectChecker(context) {}

  // A person requests something that may lead above what the battery permits.
  void OnRaiseRequest() { raise_requested_ = true; }
  // A request of a person has been accepted.
  void OnAccepted(const event::PolicyRequested& requested);
  // A power-off has happened, or may not happen any more.
  void ForgetPowerOff() { power_due_.reset(); }
  void OnBattery(int percent, bool charging);
  void OnRecord(const SimulatedController& controller, const action::Record& record);

  // Checked as soon as nothing else is under way. `at_rest`: the stored policy must be loaded by
  // then.
  void CheckCeiling(const SimulatedController& controller, bool at_rest);
  void CheckQuiet(const SimulatedController& controller);
  // Whether the policy of that controller leads the machine to that state.
  bool ByPolicy(const SimulatedController& controller, const State& state);
  // The state of its machine has changed; `from`: the one before.
  void CheckPolicyChange(const SimulatedController& controller, const State& from);
  void CheckPowerOff();

 private:
  using LevelsLeft = std::array<bool, 2>;  // Protected and LowPower
  struct Raise {  // as it was decided; samples may arrive during its switch
    State target;
    int percent = 0;
    LevelsLeft left{};
  };
  // Beyond a cut link two controllers may each lead a part of the machine.
  struct Seen {                // of a controller
    std::vector<Raise> up_to;  // its policy's last switches
    std::vector<State> down_to;
    std::optional<State> checked_raise;  // before its state was seen: a lowering began in that step
    bool lowering_begins = false;        // its switch is the next record
    bool noted_levels = false;
    // When it last knew a sample of the battery that permits at most LowPower, or Protected.
    std::optional<Time> low_power_at;
    std::optional<Time> protected_at;
    CommandNumber raise;  // the last one of the policy
  };
  struct Host {  // what a controller there stores, and the next one there knows
    std::optional<int> percent;
    bool charging = false;
    // The levels of Protected and LowPower; not reached, or not again since.
    LevelsLeft left = {true, true};
    std::optional<State> lowered_from;  // by the battery
  };

  void NoteLevels(const SimulatedController& controller);
  void NoteLowering(const SimulatedController& controller, const State& from);
  void ForgetEndedPolicySwitches(const SimulatedController& controller);
  void CheckRaise(const SimulatedController& controller, const Raise& raise);
  static std::optional<Raise> TakeRaise(Seen& seen, const State& target);
  void CheckPowerOffStarted(const action::Record& record);

  std::map<std::uint64_t, Seen> seen_;  // by the serial of the controller
  std::map<std::size_t, Host> hosts_;
  std::optional<std::pair<State, State>> lowered_;  // by the battery: from, to
  bool raise_requested_ = false;                    // possibly above what the battery permits
  std::optional<Time> power_due_;
  int empty_in_a_row_ = 0;        // samples of an empty battery that were published last
  int most_empty_in_a_row_ = 0;   // so far
  RecordId power_requested_ = 0;  // the record of the last request for a power-off
};

}  // namespace musher::simulation
