#include <fmt/format.h>

#include "musher/base/code.hpp"
#include "musher/cli/console/printable.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/render/text.hpp"

namespace musher::cli {
namespace {

std::string NoteOf(const RunningActuators::Actuator& actuator) {
  if (!actuator.has_status) return "its process publishes no status";
  const msg::ActuatorStatus status = Printable(actuator.status);
  std::string note;
  const auto add = [&note](const std::string& text) { note += (note.empty() ? "" : "; ") + text; };
  if (!status.target.empty()) add("busy with " + status.target);
  if (status.emergency_stop != 0) {
    const std::string& by = status.emergency_stop_by;
    const std::string& reason = status.emergency_stop_reason;
    add("stopped by an emergency stop" + (by.empty() ? "" : " by " + by) +
        (reason.empty() ? "" : ": " + reason));
  }
  if (status.outcome_code != kCodeOk) add(WithCode(status.outcome_message, status.outcome_code));
  return note;
}

}  // namespace

std::string RunningText(const std::map<std::string, RunningActuators::Actuator>& running,
                        bool colour) {
  Table table({"ACTUATOR", "STATE", "PID", "NOTE"});
  for (const auto& [name, actuator] : running) {
    const std::string state = actuator.has_status ? Printable(actuator.status.state) : "-";
    table.Add({{Printable(name)},
               {state, StyleOfState(state)},
               {actuator.status.pid == 0 ? "-" : std::to_string(actuator.status.pid)},
               {NoteOf(actuator)}});
  }
  return table.Text(colour);
}

std::string PidText(std::int64_t pid) {
  return pid == 0 ? "" : fmt::format(" (pid {})", pid);
}

std::string RunningNames(const std::map<std::string, RunningActuators::Actuator>& running) {
  std::string names;
  for (const auto& [name, actuator] : running) {
    names += (names.empty() ? "" : ", ") + Printable(name) + PidText(actuator.status.pid);
  }
  return names;
}

std::string EndingText(const std::vector<DirectTearDown::Outcome>& outcomes, bool colour) {
  Table table({"ACTUATOR", "PID", "END"});
  for (const DirectTearDown::Outcome& outcome : outcomes) {
    std::string end = !outcome.ended      ? "still running"
                      : outcome.torn_down ? "torn down, exited"
                                          : "exited without TearDown";
    if (!outcome.signal.empty()) end += ", after " + outcome.signal;
    if (!outcome.torn_down && !outcome.trouble.empty()) end += ": " + outcome.trouble;
    table.Add({{Printable(outcome.name)},
               {std::to_string(outcome.pid)},
               {Printable(end), outcome.ended ? Style::kPlain : Style::kBad}});
  }
  return table.Text(colour);
}

std::string OthersText(const std::vector<DirectTearDown::Other>& others) {
  std::string names;
  for (const DirectTearDown::Other& other : others) {
    names += fmt::format("{}{} (pid {} of host {})", names.empty() ? "" : ", ",
                         Printable(other.name), other.pid, Printable(other.host));
  }
  return fmt::format(
      "{} still {}, beside what was ended; `musher down --without-controller` ends "
      "{}, too, when it is repeated",
      names, others.size() == 1 ? "runs" : "run", others.size() == 1 ? "it" : "them");
}

}  // namespace musher::cli
