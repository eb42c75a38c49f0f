#include <fmt/format.h>

#include <algorithm>
#include <climits>

#include "musher/base/code.hpp"
#include "musher/cli/console/printable.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/render/text.hpp"

namespace musher::cli {
namespace {

// A name in a sentence, also the empty one that a person gave.
std::string NameOrEmpty(const std::string& name) {
  return name.empty() ? "''" : name;
}

Style StyleOfOutcome(std::string_view outcome) {
  if (outcome == "done") return Style::kGood;
  if (outcome == "skipped" || outcome == "undone" || outcome == "unsupported") return Style::kBusy;
  return Style::kBad;
}

}  // namespace

std::string SwitchText(const msg::SetState::Response& shown, bool colour) {
  const msg::SetState::Response result = Printable(shown);
  std::string text = Paint(result.outcome, StyleOfOutcome(result.outcome), colour) + ": " +
                     (result.state.empty()      ? "nothing switched"
                      : result.actuator.empty() ? "the machine is in " + result.state
                                                : result.actuator + " is in " + result.state);
  if (result.switch_number != 0) text += fmt::format(" (switch {})", result.switch_number);
  if (result.outcome == "done" && !result.reason.empty()) text += "; " + result.reason;
  text += '\n';
  if (result.actuators.empty()) return text;
  Table table({"ACTUATOR", "OUTCOME", "TOOK", "STATE", "NOTE"});
  for (const msg::ActuatorOutcome& a : result.actuators) {
    table.Add({{a.name},
               {a.outcome, StyleOfOutcome(a.outcome)},
               {a.duration_ms > 0 ? fmt::format("{:.1f} ms", a.duration_ms) : "-"},
               {a.state, StyleOfState(a.state)},
               {WithCode(a.message, a.code), Style::kDim}});
  }
  return text + table.Text(colour);
}

std::string SwitchError(const msg::SetState::Response& result) {
  const std::string target =
      (result.actuator.empty() ? "" : result.actuator + " to ") + NameOrEmpty(result.target);
  return target + " is " + result.outcome + ": " +
         (result.reason.empty() ? CodeText(result.code) : result.reason);
}

std::string PlanError(const msg::GetPlan::Response& plan) {
  const std::string target =
      (plan.actuator.empty() ? "" : plan.actuator + " to ") + NameOrEmpty(plan.target);
  return target + " would be refused: " + plan.reason;
}

std::string PlanText(const msg::GetPlan::Response& shown, bool colour) {
  const msg::GetPlan::Response plan = Printable(shown);
  // An unknown actuator has no state.
  std::string text = (plan.state.empty() ? "" : plan.state + " \u2192 ") + NameOrEmpty(plan.target);
  if (!plan.actuator.empty()) text = plan.actuator + ": " + text;
  if (!plan.allowed) {
    text += "  " + Paint("would be refused", Style::kBad, colour) + ": " +
            WithCode(plan.reason, plan.code) + '\n';
  } else {
    const std::string waits = plan.reason.empty() ? "" : "; would wait first: " + plan.reason;
    text += "  (" + plan.direction + waits + ")\n";
  }
  if (plan.steps.empty()) return text;
  Table table({"WAVE", "ACTUATOR", "FROM", "TO", "DEADLINE", "NOTE"});
  std::vector<msg::PlanStep> steps = plan.steps;
  std::stable_sort(steps.begin(), steps.end(), [](const auto& a, const auto& b) {
    return (a.wave > 0 ? a.wave : INT_MAX) < (b.wave > 0 ? b.wave : INT_MAX);
  });
  for (const msg::PlanStep& s : steps) {
    const bool driven = s.wave > 0;
    table.Add({{driven ? std::to_string(s.wave) : "-"},
               {s.name},
               {s.from, StyleOfState(s.from)},
               {driven ? s.to : "", StyleOfState(s.to)},
               {driven ? fmt::format("{:g} s", static_cast<double>(s.deadline_ms) / 1000) : ""},
               {s.note, Style::kDim}});
  }
  return text + table.Text(colour);
}

}  // namespace musher::cli
