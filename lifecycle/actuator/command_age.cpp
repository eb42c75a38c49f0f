#include "musher/lifecycle/actuator/command_age.hpp"

#include "musher/base/code.hpp"

namespace musher {
namespace {

// No process of a robot runs for longer.
constexpr Duration kLongestRun = std::chrono::hours(24 * 365 * 10);

std::string Quantity(Duration d) {
  return std::to_string(ToMilliseconds(d)) + " ms";
}

}  // namespace

std::optional<Error> CheckAge(const SwitchCommand& command, Time now) {
  // The times of an unknown sender may be arbitrary: invalid ones are not used.
  const bool possible = command.status_stamp <= now && command.status_stamp >= now - kLongestRun &&
                        command.since_status >= Duration::zero() &&
                        command.since_status <= kLongestRun;
  if (!possible) return Error{kCodeParametersInvalid, "the command carries no valid age"};
  const Duration age = now - command.status_stamp - command.since_status;
  if (age <= command.budget) return std::nullopt;
  return Error{kCodeTimeout, "the command is " + Quantity(age) + " old and was good for " +
                                 Quantity(command.budget)};
}

}  // namespace musher
