#include <fmt/format.h>

#include "musher/controller/cli/render/printable.hpp"
#include "musher/controller/cli/render/table.hpp"
#include "musher/controller/cli/render/text.hpp"
#include "musher/controller/cli/wall_time.hpp"

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
  const msg::GetBehavior::Response told = Printable(report);
  std::string text = Paint(name, Style::kBold, colour) + "  ";
  if (told.running) {
    text += Paint(told.current_state, StyleOf(told), colour) +
            fmt::format("  {}  for {:.3f} s", told.operating_mode, told.time_in_state_s) +
            (told.ticking
                 ? ""
                 : "  " + Paint(told.held_by_stop ? "paused, held by the emergency stop" : "paused",
                                Style::kBusy, colour)) +
            '\n';
  } else {
    text += Paint("does not run", Style::kBad, colour) + '\n';
  }
  text += fmt::format("{} tick{} in {:.3f} s of its time\n", told.iter_count,
                      told.iter_count == 1 ? "" : "s", told.time_s);
  if (!told.unsafe.empty()) text += Paint("unsafe: " + told.unsafe, Style::kBad, colour) + '\n';
  if (!told.last_fault.empty()) {
    text += Paint("last fault: " + told.last_fault, Style::kBad, colour) + '\n';
  }
  if (told.history.empty()) return text;
  Table table({"AT", "TICK", "FROM", "TO", "CAUSE"});
  for (const msg::BehaviorChange& change : told.history) {
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
  const msg::GetBehavior::Response told = Printable(report);
  const std::string begin = Paint(LocalTime(wall_ns), Style::kDim, colour) + "  ";
  std::string text;
  for (const msg::BehaviorChange& change : told.history) {
    text += begin +
            fmt::format("{:>10.3f} s  {} -> {}  ", change.time_s, Named(change.from),
                        Named(change.to)) +
            Paint(CauseOf(change), IsBad(change) ? Style::kBad : Style::kPlain, colour) + '\n';
  }
  // A machine inside of the state has moved.
  const bool inside = told.current_state.find('/') != std::string::npos;
  if (told.history.empty() || inside) {
    text += begin + fmt::format("{:>10.3f} s  {}\n", told.time_s, Named(told.current_state));
  }
  return text;
}

}  // namespace musher::cli
