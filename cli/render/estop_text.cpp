// Text output of an emergency stop and of `musher restart`.

#include <fmt/format.h>

#include "musher/cli/console/printable.hpp"
#include "musher/cli/render/text.hpp"
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
  return actuator.trouble.empty() ? "stop not confirmed" : Printable(actuator.trouble);
}

// Without a controller nothing else says which robot has stopped.
std::string MachinesLine(const EstopReport& report) {
  std::vector<std::string> machines;
  for (const MachineIdentity& machine : report.machines) {
    if (std::string text = MachineText(machine); !text.empty()) machines.push_back(Printable(text));
  }
  if (machines.empty()) return "";
  return fmt::format("machine{}: {}\n", machines.size() == 1 ? "" : "s", fmt::join(machines, ", "));
}

std::string StopSummary(const EstopReport& report) {
  const std::size_t count = report.actuators.size();
  if (count == 0) return "no actuator is present";
  return count == 1 ? "1 actuator is stopped" : fmt::format("{} actuators are stopped", count);
}

// What to do after a stop.
std::string NextStep(const msg::MachineStatus& machine) {
  if (machine.phase == "failed") {
    return "continue its start with `musher set SelfCheck`, then `musher set Active`";
  }
  if (!machine.held_by_stop.empty()) {
    return fmt::format("held by the stop until `musher set {}`: {}", machine.state,
                       fmt::join(machine.held_by_stop, ", "));
  }
  if (machine.degraded.empty()) return "`musher set STATE` switches it";
  return fmt::format("`musher set {}` recovers the degraded actuators: {}", machine.state,
                     fmt::join(machine.degraded, ", "));
}

}  // namespace

std::string EstopText(const EstopReport& report, bool colour) {
  std::string text = report.earlier ? "an emergency stop was already engaged" +
                                          Signed(report.earlier->by, report.earlier->reason)
                                    : "emergency stop engaged" + Signed(report.by, report.reason);
  text = Paint(text, Style::kBad, colour) + '\n';
  if (!report.controller) text += MachinesLine(report);
  std::size_t width = 0;
  for (const auto& actuator : report.actuators) width = std::max(width, actuator.name.size());
  for (const auto& actuator : report.actuators) {
    text += fmt::format("{:<{}}  ", Printable(actuator.name), width) +
            Paint(Outcome(actuator), actuator.stopped ? Style::kPlain : Style::kBad, colour) + '\n';
  }
  if (!report.complete()) return text;
  text += StopSummary(report);
  if (!report.silent_controller.empty()) {
    return text + "; the controller has not confirmed it: " + report.silent_controller + "\n";
  }
  return text + (report.controller
                     ? "; no upward switch until `musher estop --release`\n"
                     : "; no controller leads here: `musher up FILE` takes over the stop, then "
                       "`musher estop --release` releases it\n");
}

std::string EstopError(const EstopReport& report) {
  std::string error;
  if (const auto missing = report.Missing(); !missing.empty()) {
    error = fmt::format("stop not confirmed: {}", fmt::join(missing, ", "));
  }
  if (report.controller && !report.controller_latched) {
    error += std::string(error.empty() ? "" : "; ") +
             "the controller has not latched the stop: actuators that start now do not receive it";
  }
  if (const std::string lost = report.WhyNotHeld(); !lost.empty()) {
    error += (error.empty() ? "" : "; ") + lost;
  }
  const std::string why = report.silent_controller.empty()
                              ? report.unknown
                              : "the controller has not confirmed it: " + report.silent_controller;
  if (!why.empty()) error += (error.empty() ? "" : "; ") + why;
  return error;
}

std::string StopsToRelease(const msg::MachineStatus& shown) {
  const msg::MachineStatus machine = Printable(shown);
  std::string text = "releasing the emergency stop" +
                     Signed(machine.emergency_stop_by, machine.emergency_stop_reason);
  const std::vector<std::string>& ids = machine.stop_ids;
  if (ids.size() > 1) {
    text += fmt::format(" and {} more (ids {})", ids.size() - 1, fmt::join(ids, ", "));
  }
  return text + '\n';
}

std::string ReleaseText(const msg::MachineStatus& shown, bool colour) {
  const msg::MachineStatus machine = Printable(shown);
  return "emergency stop released; states are unchanged\n" + machine.machine + " is in " +
         Paint(machine.state, StyleOfState(machine.state), colour) + " (" + machine.phase + "); " +
         NextStep(machine) + '\n';
}

std::string RestartText(const msg::ActuatorInfo& shown, bool colour) {
  const msg::ActuatorInfo actuator = Printable(shown);
  return actuator.name + " is back in " +
         Paint(actuator.state, StyleOfState(actuator.state), colour) + PidText(actuator.pid) + '\n';
}

}  // namespace musher::cli
