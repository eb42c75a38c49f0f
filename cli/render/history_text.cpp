#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <sstream>

#include "musher/base/code.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/render/text.hpp"

namespace musher::cli {
namespace {

std::string Sentence(const std::string& message, std::int32_t code, bool colour) {
  if (code == kCodeOk) return Printable(message);
  return Paint(WithCode(Printable(message), code), Style::kBad, colour);
}

// A CSV field, quoted if necessary.
std::string Field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + '"';
}

// A backtrace below its message. JSON data is not shown.
std::string Below(const std::string& data) {
  if (data.starts_with('{')) return "";
  std::istringstream lines(data);
  std::string text;
  for (std::string line; std::getline(lines, line);) text += "    " + Printable(line) + '\n';
  return text;
}

// A backtrace beside its message, by its length.
std::string Folded(const std::string& data) {
  if (data.empty() || data.starts_with('{')) return "";
  const auto lines = static_cast<std::size_t>(std::count(data.begin(), data.end(), '\n'));
  return "  [" + Counted(std::max<std::size_t>(lines, 1), "line") + " in `musher history`]";
}

// The entries behind the first, each with its cause below.
std::string Causes(const CauseChain& chain, bool colour) {
  std::string text;
  for (std::size_t i = 1; i < chain.entries.size(); ++i) {
    const msg::HistoryEntry& e = chain.entries[i];
    text += Paint(LocalText(e.wall_ns), Style::kDim, colour) + "    because " +
            Sentence(e.message, e.code, colour) + Folded(e.data) + '\n';
  }
  if (chain.complete) return text;
  return text + std::string(23, ' ') + "    because of an event before these entries\n";
}

// Whether a cause is the failure of the actuator that the reason of the switch names.
bool CauseIsReason(const CauseChain& change) {
  const std::string& reason = change.entries.front().message;
  return std::any_of(std::next(change.entries.begin()), change.entries.end(),
                     [&reason](const msg::HistoryEntry& cause) {
                       return cause.code != kCodeOk && !cause.actuator.empty() &&
                              reason.find(": " + cause.actuator + ": ") != std::string::npos;
                     });
}

std::string ChangeText(const Why& why, bool colour) {
  if (why.change.entries.empty()) return "";
  const msg::HistoryEntry& went = why.change.entries.front();
  const std::string number =
      went.switch_number == 0 ? "" : fmt::format(" (switch {})", went.switch_number);
  const bool has_reason = went.code != kCodeOk && !CauseIsReason(why.change);
  return Paint(LocalText(went.wall_ns), Style::kDim, colour) + "  the machine went to " +
         Paint(Printable(why.state), StyleOfState(why.state), colour) + number +
         (has_reason ? ": " + Sentence(went.message, went.code, colour) : "") + '\n' +
         Causes(why.change, colour);
}

std::string FailureText(const std::string& label, const CauseChain& failure, bool colour) {
  if (failure.entries.empty()) return "";
  const msg::HistoryEntry& failed = failure.entries.front();
  return Paint(LocalText(failed.wall_ns), Style::kDim, colour) + "  " + label + ": " +
         Sentence(failed.message, failed.code, colour) + Folded(failed.data) + '\n' +
         Causes(failure, colour);
}

}  // namespace

std::string HistoryText(const std::vector<msg::HistoryEntry>& entries, bool colour) {
  std::string text;
  for (const msg::HistoryEntry& e : entries) {
    text += Paint(LocalText(e.wall_ns), Style::kDim, colour) +
            fmt::format("  {:<9}", Printable(e.kind)) + Sentence(e.message, e.code, colour) + '\n' +
            Below(e.data);
  }
  return text;
}

std::string HistoryCsv(const std::vector<msg::HistoryEntry>& entries, bool head) {
  std::string text = head ? "time,epoch,switch,kind,actuator,code,message\r\n" : "";
  for (const msg::HistoryEntry& e : entries) {
    text += fmt::format("{},{},{},{},{},{},{}\r\n", UtcText(e.wall_ns), e.epoch, e.switch_number,
                        Field(e.kind), Field(e.actuator), e.code, Field(e.message));
  }
  return text;
}

std::string WhyText(const Why& why, bool colour) {
  const std::string change = ChangeText(why, colour);
  const std::string failure = FailureText("last failure", why.failure, colour);
  const std::string refused = FailureText("last request", why.refused, colour);
  const bool failure_first = why.change.entries.empty() || (!why.failure.entries.empty() &&
                                                            why.failure.entries.front().wall_ns >
                                                                why.change.entries.front().wall_ns);
  return refused + (failure_first ? failure + change : change + failure);
}

std::string ProgressText(const Progress& progress, bool colour) {
  return Paint(LocalTime(progress.wall_ns), Style::kDim, colour) + "  " +
         Sentence(progress.message, progress.code, colour) + '\n';
}

std::string ConfigSummary(const MachineConfig& config) {
  int stages = 1;
  for (const ActuatorConfig& a : config.actuators) stages = std::max(stages, a.stage);
  return Counted(config.actuators.size(), "actuator") + ", " +
         Counted(config.states.size(), "state") + ", " + Counted(stages, "stage");
}

}  // namespace musher::cli
