#include <fmt/format.h>

#include "musher/base/code.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/render/text.hpp"

namespace musher::cli {
namespace {

using Mark = recording::ReplayLine::Mark;

std::string LineText(const recording::ReplayLine& line, bool colour) {
  const JournalEntry& e = line.entry;
  const char* mark = line.mark == Mark::kSame ? "  " : line.mark == Mark::kNew ? "+ " : "- ";
  const Style style = line.mark == Mark::kSame  ? Style::kPlain
                      : line.mark == Mark::kNew ? Style::kGood
                                                : Style::kBad;
  return Paint(mark, style, colour) + Paint(LocalText(e.wall_ns), Style::kDim, colour) +
         fmt::format("  {:<9}", Printable(e.kind)) +
         Paint(WithCode(Printable(e.message), e.code), style, colour) + '\n';
}

}  // namespace

std::string ReplayText(const recording::ReplayReport& report, bool colour) {
  std::string text;
  const std::string* input = nullptr;  // of the last printed differences
  const auto add_input = [&] {
    if (input != nullptr) text += Paint("    on " + Printable(*input), Style::kDim, colour) + '\n';
    input = nullptr;
  };
  for (const recording::ReplayLine& line : report.lines) {
    if (input != nullptr && line.input != *input) add_input();
    if (line.mark != Mark::kSame) input = &line.input;
    if (line.mark == Mark::kSame && report.other_config) continue;
    text += LineText(line, colour);
  }
  add_input();
  if (report.other_config) {
    text += "the machine ended in " + Printable(report.recorded_state) +
            ", with the other config in " + Printable(report.replayed_state) + '\n';
  }
  if (report.not_replayed > 0) {
    text += Counted(report.not_replayed, "input") + " before the first snapshot left out\n";
  }
  text += Counted(report.inputs, "input") + ", " + Counted(report.decisions, "decision") + ": ";
  text += report.equal() ? "all as recorded\n" : Counted(report.differences, "difference") + "\n";
  return text;
}

}  // namespace musher::cli
