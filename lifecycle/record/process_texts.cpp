// Sentences about the process of an actuator.

#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/record/texts.hpp"

namespace musher::texts {

RecordText ProcessStarted(const std::string& actuator, std::int32_t pid) {
  return MakeText(EventName::kProcessStarted, "{actuator} started (pid {pid})",
                  {{"actuator", actuator}, {"pid", pid}});
}

RecordText ProcessStartedOn(const std::string& host, const std::string& actuator, std::int32_t pid,
                            bool found) {
  const std::string what = found ? "runs on host {host} already" : "started on host {host}";
  return MakeText(EventName::kProcessStarted, "{actuator} " + what + " (pid {pid})",
                  {{"actuator", actuator}, {"host", host}, {"pid", pid}});
}

RecordText ProcessExited(const std::string& actuator, std::int32_t pid, const std::string& how) {
  return MakeText(EventName::kProcessExited, "{actuator}'s process {pid} ended: {how}",
                  {{"actuator", actuator}, {"pid", pid}, {"how", how}});
}

RecordText ProcessExitAssumed(std::int32_t pid) {
  return MakeText(EventName::kProcessExitAssumed,
                  "no exit reported for process {pid} after SIGKILL; it is assumed to have exited",
                  {{"pid", pid}});
}

RecordText ProcessUnproven(const std::string& actuator, std::int32_t pid, const std::string& why) {
  return MakeText(EventName::kProcessUnproven,
                  "{actuator} reports process {pid} of this host as its own, without proof: "
                  "{reason}; that process is not watched, traced or signalled",
                  {{"actuator", actuator}, {"pid", pid}, {"reason", why}});
}

RecordText BacktraceStarted(const std::string& actuator, std::int32_t pid) {
  return MakeText(EventName::kBacktraceStarted,
                  "taking a backtrace of {actuator}; then process {pid} gets SIGKILL",
                  {{"actuator", actuator}, {"pid", pid}});
}

RecordText BacktraceTaken(const std::string& actuator) {
  return MakeText(EventName::kBacktraceTaken, "backtrace of {actuator}:", {{"actuator", actuator}});
}

RecordText RestartRequested(const std::string& actuator, const std::string& by) {
  return MakeText(EventName::kRestartRequested,
                  std::string("restart of {actuator} requested") + (by.empty() ? "" : " by {by}"),
                  {{"actuator", actuator}, {"by", by}});
}

RecordText RestartScheduled(const std::string& actuator, Duration delay, int restart, int limit) {
  return MakeText(EventName::kRestartScheduled,
                  "{actuator}: restarting in {delay_ms} ms ({restart} of {limit})",
                  {{"actuator", actuator},
                   {"delay_ms", ToMilliseconds(delay)},
                   {"restart", restart},
                   {"limit", limit}});
}

RecordText ProcessNotStarted(const std::string& why) {
  return MakeText(EventName::kProcessNotStarted, "its process could not be started: {reason}",
                  {{"reason", why}});
}

RecordText Exited(std::int32_t pid, const std::string& how, bool clean, bool in_set_up) {
  return MakeText(clean ? EventName::kActuatorExited : EventName::kActuatorCrashed,
                  std::string(clean ? "ended" : "crashed") + (in_set_up ? " during SetUp" : "") +
                      ": its process {pid} ended: {how}",
                  {{"pid", pid}, {"how", how}});
}

RecordText RestartPrevented(const std::string& how, int exit_code, const std::string& actuator) {
  const std::string why = exit_code == kUsageExitCode ? "means a configuration error"
                                                      : "is one of its restart_prevent_exit_codes";
  return MakeText(EventName::kRestartPrevented,
                  "{how}; not restarted automatically, because exit code {exit_code} " + why +
                      "; restart it with `musher restart {actuator}`",
                  {{"how", how}, {"exit_code", exit_code}, {"actuator", actuator}});
}

RecordText GivenUp(const std::string& actuator, int restarts,
                   const std::optional<std::string>& why) {
  return MakeText(EventName::kRestartLimitReached,
                  "given up after {restarts} restarts, until `musher restart {actuator}`; {reason}",
                  {{"restarts", restarts},
                   {"actuator", actuator},
                   {"reason", why.value_or("its process ended")}});
}

RecordText GivenUpBefore(const State& lost_in) {
  const bool is_known = !lost_in.empty() && lost_in != kUnknownState;
  const std::string where = is_known ? ", lost in {state}" : "";
  return MakeText(EventName::kRestartLimitReached,
                  "given up before this controller started" + where +
                      "; only a restart that a person requests starts it",
                  {{"state", lost_in}});
}

RecordText RestartedTooOften(int starts, Duration reset_after) {
  return MakeText(EventName::kRestartLimitReached,
                  "started {starts} times in a row; not driven until it has run for "
                  "{reset_after_ms} ms",
                  {{"starts", starts}, {"reset_after_ms", ToMilliseconds(reset_after)}});
}

}  // namespace musher::texts
