#include "musher/cli/machine/restart_call.hpp"

#include <variant>

#include "musher/base/scheduling.hpp"

namespace musher::cli {
namespace {

constexpr Duration kRestartTimeout = std::chrono::seconds(60);

Failure WithHint(Failure failure, const std::string& actuator, const Link& link) {
  const pid_t leader = link.LeaderHere();
  const bool stopped = leader != 0 && RunStateOf(leader) == ProcessRunState::kStopped;
  if (stopped && failure.exit == ExitCode::kNoAnswer) {
    failure.error.message += "; " + actuator + " is not restarted while it is stopped";
  } else if (failure.exit == ExitCode::kNoAnswer || failure.exit == ExitCode::kInterrupted) {
    failure.error.message +=
        "; the restart of " + actuator + " continues, `musher status` shows its outcome";
  } else if (failure.exit == ExitCode::kUnknownEnd) {
    failure.error.message +=
        "; `musher up` with the same config takes control of what still runs, and `musher status` "
        "then shows whether " +
        actuator + " is back";
  }
  return failure;
}

}  // namespace

std::optional<Failure> RestartActuator(Link& link, const std::string& actuator) {
  const auto answer = link.CallLeader<msg::RestartActuator>(
      "restart_actuator", {actuator, UserAtHost()}, kRestartTimeout);
  if (const auto* failure = std::get_if<Failure>(&answer))
    return WithHint(*failure, actuator, link);
  const auto& restarted = std::get<msg::RestartActuator::Response>(answer);
  if (restarted.code == kCodeOk) return std::nullopt;
  return Failure{ExitCodeOfRefusal(restarted.code),
                 {restarted.code, "restart " + actuator + ": " + restarted.reason}};
}

}  // namespace musher::cli
