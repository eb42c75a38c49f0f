// Of the process of an actuator.

#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/record/texts.hpp"

namespace musher::texts {
namespace {

std::string Ended(std::int32_t pid, const std::string& how) {
  return "process " + std::to_string(pid) + " ended: " + how;
}

}  // namespace

RecordText ProcessStarted(const std::string& actuator, std::int32_t pid) {
  return {EventName::kProcessStarted, actuator + " started (pid " + std::to_string(pid) + ")"};
}

RecordText ProcessExited(const std::string& actuator, std::int32_t pid, const std::string& how) {
  return {EventName::kProcessExited, actuator + "'s " + Ended(pid, how)};
}

RecordText ProcessExitAssumed(std::int32_t pid) {
  return {EventName::kProcessExitAssumed, "no exit reported for process " + std::to_string(pid) +
                                              " after SIGKILL; it is assumed to have exited"};
}

RecordText BacktraceStarted(const std::string& actuator, std::int32_t pid) {
  return {EventName::kBacktraceStarted, "taking a backtrace of " + actuator + "; then process " +
                                            std::to_string(pid) + " gets SIGKILL"};
}

RecordText BacktraceTaken(const std::string& actuator) {
  return {EventName::kBacktraceTaken, "backtrace of " + actuator + ":"};
}

RecordText RestartRequested(const std::string& actuator) {
  return {EventName::kRestartRequested, "restart of " + actuator + " requested"};
}

RecordText RestartScheduled(const std::string& actuator, Duration delay, int restart, int limit) {
  return {EventName::kRestartScheduled,
          actuator + ": restarting in " + std::to_string(ToMilliseconds(delay)) + " ms (" +
              std::to_string(restart) + " of " + std::to_string(limit) + ")"};
}

RecordText ProcessNotStarted(const std::string& why) {
  return {EventName::kProcessNotStarted, "its process could not be started: " + why};
}

RecordText Exited(std::int32_t pid, const std::string& how, bool clean, bool in_set_up) {
  return {clean ? EventName::kActuatorExited : EventName::kActuatorCrashed,
          (clean ? "ended: its " : "crashed: its ") + Ended(pid, how) +
              (in_set_up ? " during SetUp" : "")};
}

RecordText RestartPrevented(const std::string& how, int exit_code, const std::string& actuator) {
  const std::string code = "exit code " + std::to_string(exit_code);
  return {EventName::kRestartPrevented,
          how + "; not restarted automatically, because " + code +
              (exit_code == kUsageExitCode ? " means a configuration error"
                                           : " is one of its restart_prevent_exit_codes") +
              "; restart it with `musher restart " + actuator + "`"};
}

RecordText GivenUp(int restarts, const std::optional<std::string>& why) {
  return {EventName::kRestartLimitReached, "given up after " + std::to_string(restarts) +
                                               " restarts; " + why.value_or("its process ended")};
}

RecordText RestartedTooOften(int starts, Duration reset_after) {
  return {EventName::kRestartLimitReached, "started " + std::to_string(starts) +
                                               " times in a row; not driven until it has run for " +
                                               std::to_string(ToMilliseconds(reset_after)) + " ms"};
}

}  // namespace musher::texts
