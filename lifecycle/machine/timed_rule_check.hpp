#pragma once
// Whether a rule with a time holds (config/user_rules.hpp), by what is seen of the machine.
//
//            the machine goes to the state
//   waits ──▶ begun ──▶ met           the subject is in one of its states in time
//     ▲         └─────▶ violated ──▶ met     it is not; it is there later
//     └── the machine goes elsewhere, from each
//
// The time begins when a switch of the machine to the state begins, or where the machine is found
// in it. Where the machine goes elsewhere before the time is over, the rule counts no more: there
// the subject has another place.
//
// Pure: the time is an argument. Any thread, one at a time.

#include <cstdint>
#include <optional>

#include "musher/base/time.hpp"
#include "musher/lifecycle/config/user_rules.hpp"
#include "musher/lifecycle/machine/machine.hpp"

namespace musher {

// The state that the machine goes to, else is in; none: it is not started, or is torn down, or
// another controller leads it.
std::optional<State> GoalOf(const MachineConfig& config, const Machine& machine);

class TimedRuleCheck {
 public:
  // To be called after each step of the controller, and at due(). `goal`: GoalOf(); `state`: of the
  // subject, empty where it has exited, none where it is not known: then the rule waits until it
  // is. Whether the rule is violated since this call.
  bool Update(const TimedRule& rule, const std::optional<State>& goal,
              const std::optional<State>& state, Time now);

  // When the time is over; none: it has not begun, or the rule is met or violated.
  std::optional<Time> due() const;
  bool is_violated() const { return progress_ == Progress::kViolated; }
  const TimedRuleCoverage& coverage() const { return coverage_; }

 private:
  enum class Progress : std::uint8_t { kWaits, kBegun, kMet, kViolated };

  Progress progress_ = Progress::kWaits;
  Time due_{};
  bool is_over_ = false;       // the time, while the state of the subject is not known
  bool is_elsewhere_ = false;  // the subject was, at the last call
  TimedRuleCoverage coverage_;
};

}  // namespace musher
