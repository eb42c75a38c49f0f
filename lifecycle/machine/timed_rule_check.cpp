#include "musher/lifecycle/machine/timed_rule_check.hpp"

#include "musher/lifecycle/state.hpp"

namespace musher {

std::optional<State> GoalOf(const MachineConfig& config, const Machine& machine) {
  const bool is_led = machine.phase != Phase::kIdle && machine.phase != Phase::kStopped &&
                      machine.phase != Phase::kFenced;
  if (!is_led) return std::nullopt;
  const auto& current = machine.current;
  if (!current || current->only || current->rollback.under_way) return machine.state;
  // A check leaves the machine in its state, unless it is a step of a start.
  const bool stays = current->direction == Direction::kCheck &&
                     config.RankOf(machine.state).has_value() && machine.state != kError;
  return stays ? machine.state : current->target;
}

bool TimedRuleCheck::Update(const TimedRule& rule, const std::optional<State>& goal,
                            const std::optional<State>& state, Time now) {
  if (!goal || *goal != rule.of) {
    progress_ = Progress::kWaits;
    return false;
  }
  if (progress_ == Progress::kWaits) {
    progress_ = Progress::kBegun;
    due_ = now + rule.within;
    is_over_ = is_elsewhere_ = false;
    ++coverage_.begun;
  }
  const bool is_there = state && rule.IsMetIn(*state);
  if (progress_ == Progress::kViolated && is_there) progress_ = Progress::kMet;
  if (progress_ != Progress::kBegun) return false;
  // It was elsewhere until this call.
  const bool comes_late = now > due_ && is_elsewhere_;
  is_elsewhere_ = state && !is_there;
  is_over_ = now >= due_;
  if (comes_late || (is_over_ && is_elsewhere_)) {
    progress_ = is_there ? Progress::kMet : Progress::kViolated;
    return true;
  }
  if (is_there) {
    progress_ = Progress::kMet;
    ++coverage_.met;
  }
  return false;
}

std::optional<Time> TimedRuleCheck::due() const {
  return progress_ == Progress::kBegun && !is_over_ ? std::optional(due_) : std::nullopt;
}

}  // namespace musher
