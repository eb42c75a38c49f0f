#include "musher/modules/exec/stop_confirmation.hpp"

#include <utility>

namespace musher::exec {

StopConfirmation::StopConfirmation(std::string not_ended) : not_ended_(std::move(not_ended)) {}

// ActuatorShell says the same, but only of a callback on the way up.
std::string StopConfirmation::Trouble() const {
  if (!action_trouble_.empty() || command_.empty()) return action_trouble_;
  return "its callback for " + command_ + " still runs and may switch on again";
}

std::uint64_t StopConfirmation::BeginAction() {
  stopped_meanwhile_ = !command_.empty();
  AwaitNextAction();
  return actions_;
}

void StopConfirmation::EndAction(std::uint64_t number, const std::string& error) {
  if (number == actions_) action_trouble_ = error;
}

void StopConfirmation::BeginCommand(const State& state, StopAtBegin stop) {
  command_ = state;
  stopped_before_ = stop == StopAtBegin::kBefore;
  stopped_meanwhile_ = stop == StopAtBegin::kSince;
}

bool StopConfirmation::EndCommand(bool nothing_left) {
  command_ = State();
  const bool before = std::exchange(stopped_before_, false) && !nothing_left;
  if (!std::exchange(stopped_meanwhile_, false)) return before;
  AwaitNextAction();
  return false;
}

// The action that is under way confirms nothing any more.
void StopConfirmation::AwaitNextAction() {
  ++actions_;
  action_trouble_ = not_ended_;
}

}  // namespace musher::exec
