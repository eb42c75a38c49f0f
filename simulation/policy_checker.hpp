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
  // A controller of that host makes a record; OnRecord() may get it next.
  void OnRecordOn(std::size_t host) { recording_host_ = host; }
  void OnRecord(const action::Record& record);

  // Checked as soon as nothing else is under way. `at_rest`: the stored policy must be loaded by
  // then.
  void CheckCeiling(const SimulatedController& controller, bool at_rest);
  void CheckQuiet(const SimulatedController& controller);
  // Whether the policy leads the machine to that state.
  bool ByPolicy(const State& state) const;
  // The machine's state has changed; `from`: the one before.
  void CheckPolicyChange(const Machine& machine, const State& from);
  void CheckPowerOff();

 private:
  struct Seen {  // of a controller
    // When it last knew a sample of the battery that permits at most LowPower, or Protected.
    std::optional<Time> low_power_at;
    std::optional<Time> protected_at;
    CommandNumber raise;  // the last one of the policy
  };
  struct Level {
    int percent = 0;
    bool charging = false;
  };

  void NoteLevels(const BatteryPolicy& policy, int percent);
  void NoteLowering(const State& from);
  void ForgetEndedPolicySwitches(const Machine& machine);
  void CheckRaise(const State& raised_to, int percent);
  void CheckPowerOffStarted(const action::Record& record);

  std::map<std::uint64_t, Seen> seen_;  // by the serial of the controller
  std::vector<State> policy_up_to_;     // the targets of its last switches
  std::vector<State> policy_down_to_;
  std::map<std::size_t, Level> level_on_;  // of a host: what a controller there knew last
  std::optional<int> raised_at_;           // the battery's percentage when it last decided to raise
  // The levels of Protected and LowPower; not reached, or not again since.
  std::array<bool, 2> left_ = {true, true};
  std::optional<State> checked_raise_;  // before its state was seen: a lowering began in that step
  bool lowering_begins_ = false;        // its switch is the next record
  std::optional<std::pair<State, State>> lowered_;  // by the battery: from, to
  std::size_t recording_host_ = 0;                  // of the controller that makes a record
  std::map<std::size_t, State> lowered_on_;  // by a controller of that host, which stores it: from
  bool raise_requested_ = false;             // possibly above what the battery permits
  std::optional<Time> power_due_;
  int empty_in_a_row_ = 0;        // samples of an empty battery that were published last
  int most_empty_in_a_row_ = 0;   // so far
  RecordId power_requested_ = 0;  // the record of the last request for a power-off
};

}  // namespace musher::simulation
