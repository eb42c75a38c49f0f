#include <fmt/format.h>

#include "musher/base/code.hpp"
#include "musher/base/joined.hpp"
#include "musher/cli/console/printable.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/render/description.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/controller/ros2/other_vendors.hpp"
#include "musher/lifecycle/health/health.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::cli {
namespace {

std::string Ordinal(int n) {
  const int last = n % 10;
  const bool teen = n % 100 / 10 == 1;
  const char* ending = teen || last == 0 || last > 3 ? "th"
                       : last == 1                   ? "st"
                       : last == 2                   ? "nd"
                                                     : "rd";
  return std::to_string(n) + ending;
}

bool IsWell(const msg::ActuatorInfo& a) {
  return a.health == HealthName(Health::kWell);
}

// "given up after 5 restarts; crashed: …"
bool IsGivenUp(const msg::ActuatorInfo& a) {
  return a.degraded && a.message.starts_with("given up after ");
}

// "restarting, 2nd time", or the number of restarts.
std::string RestartsOf(const msg::ActuatorInfo& a) {
  if (a.restarting)
    return "restarting" + (a.restarts > 1 ? ", " + Ordinal(a.restarts) + " time" : "");
  if (a.restarts == 0) return "";
  return a.restarts == 1 ? "1 restart" : std::to_string(a.restarts) + " restarts";
}

// What is wrong with the actuator, beginning with its health.
std::string TroubleOf(const msg::ActuatorInfo& a) {
  if (!a.degraded) return IsWell(a) ? a.message : a.health;
  const std::string why = WithCode(a.message, a.code);
  if (IsWell(a)) return "degraded: " + why;
  // Once an actuator is given up, its sentence has the number of restarts and the last fault.
  const bool says_it = a.message.starts_with(a.health) || IsGivenUp(a);
  return says_it ? why : a.health + ": " + why;
}

// The NOTE of an actuator.
Table::Cell NoteOf(const msg::ActuatorInfo& a, bool held_by_stop) {
  std::string note;
  const auto add = [&note](const std::string& text) {
    if (!text.empty()) note += (note.empty() ? "" : "; ") + text;
  };
  if (!a.target.empty()) add(a.target != a.state ? "\u2192 " + a.target : "busy with " + a.target);
  if (held_by_stop) add("held by the stop");
  if (a.held) add("held");
  // For an absent actuator its health, or that it restarts, says more.
  if (a.presence != "present" && IsWell(a) && !a.restarting) add(a.presence);
  if (!IsGivenUp(a)) add(RestartsOf(a));
  add(TroubleOf(a));
  if (a.degraded || held_by_stop) return {note, Style::kBad};
  const bool changing = !a.target.empty() || a.restarting || !IsWell(a);
  return {note, changing ? Style::kBusy : Style::kDim};
}

bool IsHeldByStop(const msg::MachineStatus& status, const msg::ActuatorInfo& a) {
  const auto& held = status.held_by_stop;
  return std::find(held.begin(), held.end(), a.name) != held.end();
}

// After the release, functions that the stop switched off stay off.
std::string HeldByStopOf(const msg::MachineStatus& status) {
  if (status.emergency_stop || status.held_by_stop.empty()) return "";
  return fmt::format("still held by the released emergency stop: {}; `musher set {}` ends that",
                     fmt::join(status.held_by_stop, ", "), status.state);
}

// The degraded actuators, each with its health if that says why.
std::vector<std::string> DegradedOf(const msg::MachineStatus& status) {
  std::vector<std::string> degraded;
  for (const msg::ActuatorInfo& a : status.actuators) {
    if (!a.degraded && IsWell(a)) continue;
    const std::string word = a.restarting ? "restarting" : IsWell(a) ? "" : a.health;
    degraded.push_back(a.name + (word.empty() ? "" : " (" + word + ")"));
  }
  return degraded;
}

std::string EmergencyStopOf(const msg::MachineStatus& status) {
  std::string text = "EMERGENCY STOP";
  if (!status.emergency_stop_by.empty()) text += " by " + status.emergency_stop_by;
  if (!status.emergency_stop_reason.empty()) text += ": " + status.emergency_stop_reason;
  return text;
}

// "the battery is at 15 %: …; kept in Active for 60 s"; may be empty.
std::string PolicyOf(const msg::PolicyInfo& p) {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  if (!p.ceiling_reason.empty()) {
    add(p.ceiling_reason);
  } else if (p.battery >= 0) {
    add(fmt::format("the battery is at {} %{}", p.battery, p.charging ? ", being charged" : ""));
  }
  if (p.battery_silent) add("no battery status received");
  if (!p.kept.empty()) add(fmt::format("kept in {} for {} s", p.kept, p.keep_s));
  if (p.low_power_switch) add("automatic LowPower when lying still: on");
  if (!p.power.empty()) add(p.power + " is under way");
  return text;
}

}  // namespace

Style StyleOfState(std::string_view state) {
  if (state == kActive) return Style::kGood;
  if (state == kError) return Style::kBad;
  if (state == kUninitialized || state == kTearDown) return Style::kDim;
  return Style::kBusy;
}

std::string StatusLegend(const msg::MachineStatus& status, bool colour) {
  const auto any = [&](auto is) {
    return std::any_of(status.actuators.begin(), status.actuators.end(), is);
  };
  std::string text;
  if (any([](const msg::ActuatorInfo& a) { return a.critical; })) {
    text += "* critical: without it the machine does not become Active\n";
  }
  if (any([](const msg::ActuatorInfo& a) { return a.held; })) {
    text += "held: switched alone, until the next switch of all\n";
  }
  return text.empty() ? text : Paint(text, Style::kDim, colour);
}

std::string StatusText(const msg::MachineStatus& shown, bool colour, const StatusTimes& times) {
  const msg::MachineStatus status = Printable(shown);
  std::string text = Paint(status.machine, Style::kBold, colour) + "  " +
                     Paint(status.state, StyleOfState(status.state), colour);
  if (!status.target.empty()) text += Paint(" \u2192 " + status.target, Style::kBusy, colour);
  text += "  (" + status.phase + ")";
  if (times.in_state_s) text += "  for " + AgeText(*times.in_state_s);
  if (!status.name_space.empty()) text += "  namespace " + status.name_space;
  const std::string up = times.up_s ? " up " + AgeText(*times.up_s) : "";
  text += Paint(fmt::format("  controller {}{}, epoch {}, switch {}", status.pid, up, status.epoch,
                            status.switch_number) +
                    (status.requested_by.empty() ? "" : " by " + status.requested_by),
                Style::kDim, colour);
  text += '\n';
  if (status.emergency_stop) {
    text += Paint(EmergencyStopOf(status) + "; no upward switch until `musher estop --release`",
                  Style::kBad, colour) +
            '\n';
  }
  for (const std::string& actuator : status.not_stopped) {
    text += Paint("NOT STOPPED: " + actuator, Style::kBad, colour) + '\n';
  }
  if (const std::string held = HeldByStopOf(status); !held.empty()) {
    text += Paint(held, Style::kBad, colour) + '\n';
  }
  if (!status.not_on_disk.empty()) {
    text += Paint("not on disk yet: " + Joined(status.not_on_disk), Style::kBad, colour) + '\n';
  }
  for (const std::string& rule : status.violated_rules) {
    text += Paint("a rule of yours is violated: " + rule, Style::kBad, colour) + '\n';
  }
  if (!status.other_machines.empty()) {
    text += Paint("another machine in this namespace and domain: " +
                      fmt::format("{}", fmt::join(status.other_machines, "; ")),
                  Style::kBusy, colour) +
            '\n';
  }
  for (const std::string& other : status.other_vendors) {
    text += Paint(other + ": " + kOtherVendorCure, Style::kBusy, colour) + '\n';
  }
  if (!status.degraded.empty()) {
    text += Paint("degraded: " + Joined(status.degraded), Style::kBad, colour) + '\n';
  }
  if (const std::string policy = PolicyOf(status.policy); !policy.empty()) {
    const bool limited = !status.policy.ceiling.empty() || status.policy.battery_silent;
    text += Paint(policy, limited ? Style::kBusy : Style::kDim, colour) + '\n';
  }
  // A machine has actuators: those that `--failed` looks for are missing.
  if (status.actuators.empty()) return text + "all actuators are present and well\n";
  Table table({"ACTUATOR", "STATE", "STAGE", "PID", "NOTE"});
  for (const msg::ActuatorInfo& a : status.actuators) {
    table.Add({{a.name + (a.critical ? "*" : "")},
               {a.state, StyleOfState(a.state)},
               {std::to_string(a.stage)},
               {a.pid == 0 ? "-" : std::to_string(a.pid)},
               NoteOf(a, IsHeldByStop(status, a))});
  }
  return text + table.Text(colour);
}

std::string HostsText(const std::vector<HostClock>& hosts, bool colour) {
  constexpr Duration kLittle = Milliseconds(1000);
  if (hosts.empty()) return "no actuator has a host of its own\n";
  Table table({"HOST", "LOGIN", "CLOCK", "ACTUATORS"});
  for (const HostClock& host : hosts) {
    const bool near = host.ahead && *host.ahead >= -kLittle && *host.ahead <= kLittle;
    table.Add({{host.name},
               {host.login},
               {host.ahead ? ClockText(*host.ahead) : "-", near ? Style::kPlain : Style::kBusy},
               {Joined(host.actuators)}});
  }
  return table.Text(colour);
}

std::string UnitsText(const std::map<std::string, std::string>& units, bool colour) {
  if (units.empty()) return {};
  std::vector<std::string> names;
  for (const auto& [actuator, unit] : units) names.push_back(unit);
  return Paint("units of systemd: " + Joined(names) + "\n", Style::kDim, colour);
}

std::string StatusLine(const msg::MachineStatus& shown, std::int64_t wall_ns) {
  const msg::MachineStatus status = Printable(shown);
  std::string line = LocalTime(wall_ns) + "  " + status.machine + "  " + status.state;
  if (!status.target.empty()) line += " \u2192 " + status.target;
  line += fmt::format("  ({}, switch {})", status.phase, status.switch_number);
  std::vector<std::string> busy;
  for (const msg::ActuatorInfo& a : status.actuators) {
    if (!a.target.empty()) busy.push_back(a.name + ": " + a.target);
  }
  if (!busy.empty()) line += "  busy: " + Joined(busy);
  if (const auto degraded = DegradedOf(status); !degraded.empty()) {
    line += "  degraded: " + Joined(degraded);
  }
  if (const std::string policy = PolicyOf(status.policy); !policy.empty()) line += "  " + policy;
  if (status.emergency_stop) line += "  " + EmergencyStopOf(status);
  for (const std::string& actuator : status.not_stopped) line += "  NOT STOPPED: " + actuator;
  if (const std::string held = HeldByStopOf(status); !held.empty()) line += "  " + held;
  if (!status.not_on_disk.empty()) line += "  not on disk yet: " + Joined(status.not_on_disk);
  for (const std::string& rule : status.violated_rules) line += "  rule violated: " + rule;
  return line;
}

}  // namespace musher::cli
