#include <fmt/format.h>

#include "musher/controller/cli/render/table.hpp"
#include "musher/controller/cli/render/text.hpp"
#include "musher/controller/cli/wall_time.hpp"
#include "musher/lifecycle/code.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::cli {
namespace {

// What is to be said about an actuator beside its state.
Table::Cell NoteOf(const msg::ActuatorInfo& a) {
  std::string note;
  const auto add = [&note](const std::string& text) { note += (note.empty() ? "" : "; ") + text; };
  Style style = Style::kDim;
  if (!a.target.empty() && a.target != a.state) {
    add("\u2192 " + a.target);
    style = Style::kBusy;
  } else if (!a.target.empty()) {
    add("busy with " + a.target);
    style = Style::kBusy;
  }
  if (a.held) add("held");
  if (a.presence != "present") add(a.presence);
  if (a.degraded) {
    add("degraded: " + Printable(a.message) + " (" + CodeText(a.code) + ")");
    style = Style::kBad;
  } else if (!a.message.empty()) {
    add(Printable(a.message));
  }
  return {note, style};
}

std::string Join(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

Style StyleOfState(std::string_view state) {
  if (state == kActive) return Style::kGood;
  if (state == kError) return Style::kBad;
  if (state == kUninitialized || state == kTearDown) return Style::kDim;
  return Style::kBusy;
}

std::string StatusText(const msg::MachineStatus& status, bool colour) {
  std::string text = Paint(status.machine, Style::kBold, colour) + "  " +
                     Paint(status.state, StyleOfState(status.state), colour);
  if (!status.target.empty()) text += Paint(" \u2192 " + status.target, Style::kBusy, colour);
  text += "  (" + status.phase + ")";
  if (!status.name_space.empty()) text += "  namespace " + status.name_space;
  text += Paint(fmt::format("  controller {}, epoch {}, switch {}", status.pid, status.epoch,
                            status.switch_number),
                Style::kDim, colour);
  text += '\n';
  if (!status.degraded.empty()) {
    text += Paint("degraded: " + Join(status.degraded), Style::kBad, colour) + '\n';
  }
  Table table({"ACTUATOR", "STATE", "STAGE", "PID", "NOTE"});
  for (const msg::ActuatorInfo& a : status.actuators) {
    table.Add({{a.name + (a.critical ? "*" : "")},
               {a.state, StyleOfState(a.state)},
               {std::to_string(a.stage)},
               {a.pid == 0 ? "-" : std::to_string(a.pid)},
               NoteOf(a)});
  }
  return text + table.Text(colour);
}

std::string StatusLine(const msg::MachineStatus& status, std::int64_t wall_ns) {
  std::string line = LocalTime(wall_ns) + "  " + status.machine + "  " + status.state;
  if (!status.target.empty()) line += " \u2192 " + status.target;
  line += fmt::format("  ({}, switch {})", status.phase, status.switch_number);
  std::vector<std::string> busy;
  for (const msg::ActuatorInfo& a : status.actuators) {
    if (!a.target.empty()) busy.push_back(a.name + ": " + a.target);
  }
  if (!busy.empty()) line += "  busy: " + Join(busy);
  if (!status.degraded.empty()) line += "  degraded: " + Join(status.degraded);
  return line;
}

}  // namespace musher::cli
