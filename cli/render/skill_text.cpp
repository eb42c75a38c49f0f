#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "musher/cli/console/printable.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/render/skill.hpp"

namespace musher::cli {
namespace {

constexpr std::size_t kColumns = 79;
constexpr int kBarColumns = 20;

// At most `columns` characters of a UTF-8 text.
std::string Shortened(const std::string& text, std::size_t columns) {
  if (Width(text) <= columns) return text;
  std::size_t shown = 0;
  std::size_t end = 0;
  for (; end < text.size(); ++end) {
    const bool begins = (static_cast<unsigned char>(text[end]) & 0xc0) != 0x80;
    if (begins && ++shown > columns) break;
  }
  return text.substr(0, end);
}

Style StyleOf(std::uint8_t status) {
  switch (status) {
    case msg::SkillFeedback::kStatusCompleted:
      return Style::kGood;
    case msg::SkillFeedback::kStatusFailed:
      return Style::kBad;
    case msg::SkillFeedback::kStatusCancelled:
      return Style::kBusy;
    default:
      return Style::kPlain;
  }
}

}  // namespace

std::string SkillsText(const std::vector<msg::SkillOffers>& all, bool whole, bool colour) {
  std::string text;
  for (const msg::SkillOffers& of : all) {
    const msg::SkillOffers shown = Printable(of);
    text += Paint(shown.actuator, Style::kBold, colour) + "  " +
            Paint(shown.action, Style::kDim, colour) + '\n';
    std::size_t width = 0;
    for (const msg::SkillOffer& offer : shown.skills) width = std::max(width, Width(offer.skill));
    for (const msg::SkillOffer& offer : shown.skills) {
      std::string line = "  " + offer.skill;
      if (!offer.summary.empty()) {
        line += std::string(width - Width(offer.skill) + 2, ' ') + offer.summary;
      }
      text += line + '\n';
      if (!whole) continue;
      for (const std::string& parameter : offer.parameters) text += "      " + parameter + '\n';
    }
  }
  return text;
}

std::string SkillReportLine(const SkillReport& report) {
  return fmt::format("{:3} %  {}\n", report.progress, Printable(report.message));
}

std::string SkillProgressText(const std::string& skill, const SkillReport& report,
                              std::int64_t seconds, bool colour) {
  const int full = std::clamp(report.progress, 0, 100) * kBarColumns / 100;
  const std::string bar = std::string(static_cast<std::size_t>(full), '#');
  const std::string rest = std::string(static_cast<std::size_t>(kBarColumns - full), '.');
  const std::string name = Shortened(Printable(skill), kColumns / 4);
  const std::string number = fmt::format("{:3} %  ", report.progress);
  const std::string time = fmt::format("  {} s", seconds);
  const std::size_t used = Width(name) + Width(number) + Width(time) + kBarColumns + 6;
  return name + "  [" + Paint(bar, Style::kGood, colour) + rest + "]  " + number +
         Shortened(Printable(report.message), kColumns - used) + time;
}

std::string_view SkillOutcomeName(SkillOutcome outcome) {
  constexpr std::array<std::string_view, 8> kNames{
      "completed", "failed", "cancelled", "refused", "lost", "no answer", "timeout", "running"};
  return kNames.at(static_cast<std::size_t>(outcome));
}

std::string SkillOutcomeWord(SkillOutcome outcome) {
  std::string word(SkillOutcomeName(outcome));
  std::replace(word.begin(), word.end(), ' ', '_');
  return word;
}

std::string SkillOutcomeText(SkillOutcome outcome, std::optional<double> duration_s) {
  const auto after = [&duration_s](const char* word) {
    return duration_s ? fmt::format(" {} {:.1f} s", word, *duration_s) : "";
  };
  std::string what;
  switch (outcome) {
    case SkillOutcome::kCompleted:
      what = "completed" + after("in");
      break;
    case SkillOutcome::kFailed:
      what = "failed" + after("after");
      break;
    case SkillOutcome::kCancelled:
      what = "was cancelled" + after("after");
      break;
    case SkillOutcome::kRefused:
      what = "was refused";
      break;
    case SkillOutcome::kLost:
      what = "is lost" + after("after");
      break;
    case SkillOutcome::kNoAnswer:
      what = "has not started";
      break;
    case SkillOutcome::kTimeout:
      what = "has not ended" + after("within");
      break;
    case SkillOutcome::kRunning:
      what = "has not ended yet";
      break;
  }
  return what;
}

std::string SkillEndText(const SkillEnd& end) {
  const std::string what = SkillOutcomeText(end.outcome, end.duration_s);
  return Printable(end.skill + " of " + end.actuator + " " + what +
                   (end.message.empty() ? "" : ": " + end.message));
}

std::string SkillPausedText(const SkillPaused& one) {
  if (!one.done) return Printable(one.actuator + ": " + one.message);
  return Printable(one.skill + " of " + one.actuator +
                   (one.pause ? " paused in " : " goes on from ") + one.message);
}

std::string SkillFeedbackLine(const msg::SkillFeedback& feedback, std::int64_t wall_ns,
                              bool colour) {
  const msg::SkillFeedback shown = Printable(feedback);
  std::string details;
  for (const msg::SkillDetail& detail : shown.details) {
    details += "  " + detail.key + " " + detail.value;
  }
  return Paint(LocalTime(wall_ns), Style::kDim, colour) +
         fmt::format("  {}  {}  {:3} %  ", shown.actuator, shown.skill, shown.progress) +
         Paint(shown.state, StyleOf(shown.status), colour) +
         (shown.message.empty() ? "" : "  " + shown.message) + Paint(details, Style::kDim, colour) +
         '\n';
}

}  // namespace musher::cli
