#include <fmt/format.h>

#include "musher/cli/console/printable.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/render/text.hpp"

namespace musher::cli {
namespace {

Style StyleOf(const msg::GetBehavior::Response& report) {
  if (!report.running || report.safety_triggered) return Style::kBad;
  return report.operating_mode == "NORMAL" ? Style::kGood : Style::kBusy;
}

std::string Named(const std::string& state) {
  return state.empty() ? "-" : state;
}

// "decided", "decided by photo"
std::string CauseOf(const msg::BehaviorChange& change) {
  return change.cause + (change.command.empty() ? "" : " by " + change.command);
}

bool IsBad(const msg::BehaviorChange& change) {
  return change.cause == "fault" || change.cause == "unsafe";
}

}  // namespace

std::string BehaviorText(const std::string& name, const msg::GetBehavior::Response& report,
                         bool colour) {
  const msg::GetBehavior::Response shown = Printable(report);
  std::string text = Paint(name, Style::kBold, colour) + "  ";
  if (shown.running) {
    text += Paint(shown.current_state, StyleOf(shown), colour) +
            fmt::format("  {}  for {:.3f} s", shown.operating_mode, shown.time_in_state_s) +
            (shown.ticking ? ""
                           : "  " + Paint(shown.held_by_stop ? "paused, held by the emergency stop"
                                                             : "paused",
                                          Style::kBusy, colour)) +
            '\n';
  } else {
    text += Paint("not running", Style::kBad, colour) + '\n';
  }
  text += fmt::format("{} tick{} in {:.3f} s of its time\n", shown.iter_count,
                      shown.iter_count == 1 ? "" : "s", shown.time_s);
  if (!shown.unsafe.empty()) text += Paint("unsafe: " + shown.unsafe, Style::kBad, colour) + '\n';
  if (!shown.last_fault.empty()) {
    text += Paint("last fault: " + shown.last_fault, Style::kBad, colour) + '\n';
  }
  if (shown.history.empty()) return text;
  Table table({"AT", "TICK", "FROM", "TO", "CAUSE"});
  for (const msg::BehaviorChange& change : shown.history) {
    table.Add({{fmt::format("{:.3f} s", change.time_s), Style::kDim},
               {std::to_string(change.tick)},
               {Named(change.from)},
               {Named(change.to)},
               {CauseOf(change), IsBad(change) ? Style::kBad : Style::kPlain}});
  }
  return text + table.Text(colour);
}

std::string BehaviorLines(const msg::GetBehavior::Response& report, std::int64_t wall_ns,
                          bool colour) {
  const msg::GetBehavior::Response shown = Printable(report);
  const std::string begin = Paint(LocalTime(wall_ns), Style::kDim, colour) + "  ";
  std::string text;
  for (const msg::BehaviorChange& change : shown.history) {
    text += begin +
            fmt::format("{:>10.3f} s  {} -> {}  ", change.time_s, Named(change.from),
                        Named(change.to)) +
            Paint(CauseOf(change), IsBad(change) ? Style::kBad : Style::kPlain, colour) + '\n';
  }
  // A nested state machine may have changed.
  const bool inside = shown.current_state.find('/') != std::string::npos;
  if (shown.history.empty() || inside) {
    text += begin + fmt::format("{:>10.3f} s  {}\n", shown.time_s, Named(shown.current_state));
  }
  return text;
}

}  // namespace musher::cli
