// What people see of an emergency stop and of a restart by hand.

#include <fmt/format.h>

#include "musher/controller/cli/render/printable.hpp"
#include "musher/controller/cli/render/text.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::cli {
namespace {

std::string Signed(const std::string& by, const std::string& reason) {
  return (by.empty() ? "" : " by " + Printable(by)) +
         (reason.empty() ? "" : ": " + Printable(reason));
}

std::string Outcome(const EstopReport::Actuator& actuator) {
  if (actuator.before) return "stopped before";
  if (actuator.stopped) return fmt::format("stopped after {} ms", ToMilliseconds(actuator.after));
  return actuator.trouble.empty() ? "does not say that it has stopped"
                                  : Printable(actuator.trouble);
}

std::string StopSummary(const EstopReport& report) {
  const std::size_t count = report.actuators.size();
  if (count == 0) return "no actuator is there";
  return count == 1 ? "1 actuator is stopped" : fmt::format("{} actuators are stopped", count);
}

// How one goes on after a stop.
std::string NextStep(const msg::MachineStatus& machine) {
  if (machine.phase == "failed") {
    return "its start goes on with `musher set SelfCheck`, then `musher set Active`";
  }
  if (!machine.held_by_stop.empty()) {
    return fmt::format("what the stop has switched off stays off until `musher set {}`: {}",
                       machine.state, fmt::join(machine.held_by_stop, ", "));
  }
  if (machine.degraded.empty()) return "`musher set STATE` moves it on";
  return fmt::format("`musher set {}` drives those there that are not: {}", machine.state,
                     fmt::join(machine.degraded, ", "));
}

}  // namespace

std::string EstopText(const EstopReport& report, bool colour) {
  std::string text = report.earlier ? "an emergency stop was engaged already" +
                                          Signed(report.earlier->by, report.earlier->reason)
                                    : "emergency stop engaged" + Signed(report.by, report.reason);
  text = Paint(text, Style::kBad, colour) + '\n';
  std::size_t width = 0;
  for (const auto& actuator : report.actuators) width = std::max(width, actuator.name.size());
  for (const auto& actuator : report.actuators) {
    text += fmt::format("{:<{}}  ", Printable(actuator.name), width) +
            Paint(Outcome(actuator), actuator.stopped ? Style::kPlain : Style::kBad, colour) + '\n';
  }
  if (!report.complete()) return text;
  text += StopSummary(report);
  return text + (report.controller
                     ? "; nothing goes up until `musher estop --release`\n"
                     : "; no controller leads here: `musher up FILE` takes the stop over, and "
                       "`musher estop --release` then ends it\n");
}

std::string EstopComplaint(const EstopReport& report) {
  std::string complaint;
  if (const auto missing = report.Missing(); !missing.empty()) {
    complaint = fmt::format("not known to be stopped: {}", fmt::join(missing, ", "));
  }
  if (report.controller && !report.controller_took) {
    complaint += std::string(complaint.empty() ? "" : "; ") +
                 "the controller has not taken the stop: whoever starts now does not hear of it";
  }
  return complaint;
}

std::string ReleaseText(const msg::MachineStatus& told, bool colour) {
  const msg::MachineStatus machine = Printable(told);
  return "the emergency stop is released; no state was changed by that\n" + machine.machine +
         " is in " + Paint(machine.state, StyleOfState(machine.state), colour) + " (" +
         machine.phase + "); " + NextStep(machine) + '\n';
}

std::string RestartText(const msg::ActuatorInfo& told, bool colour) {
  const msg::ActuatorInfo actuator = Printable(told);
  return actuator.name + " is back in " +
         Paint(actuator.state, StyleOfState(actuator.state), colour) +
         fmt::format(", process {}\n", actuator.pid);
}

}  // namespace musher::cli
