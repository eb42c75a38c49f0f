#include "musher/cli/start/repetitions.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "musher/lifecycle/event_name.hpp"

namespace musher::cli {
namespace {

// Longer than the default restart delay: a later exit counts as new.
constexpr std::int64_t kForgetAfterNs = 30'000'000'000;
// A reason printed more recently than this is still visible on the terminal. A short reason is not
// replaced.
constexpr std::int64_t kInSightNs = 10'000'000'000;
constexpr std::size_t kShortReason = 30;
constexpr std::size_t kMostReasons = 32;

bool IsDigit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

// Process numbers, times and counts become '#'; exit codes and all else stay.
std::string WithoutChangingNumbers(const std::string& message) {
  constexpr std::array<std::string_view, 5> kBefore = {"process ", "pid ", "in ", "ms (", "after "};
  std::string text;
  for (std::size_t i = 0; i < message.size(); ++i) {
    const bool first = IsDigit(message[i]) && (i == 0 || !IsDigit(message[i - 1]));
    if (first && std::any_of(kBefore.begin(), kBefore.end(),
                             [&](std::string_view word) { return text.ends_with(word); })) {
      while (i + 1 < message.size() && IsDigit(message[i + 1])) ++i;
      text += '#';
    } else {
      text += message[i];
    }
  }
  return text;
}

// What makes two lines of an actuator the same: the event, and where it can have several reasons,
// its code and the sentence.
std::string KeyOf(const Progress& progress) {
  for (const EventName counted : {EventName::kProcessStarted, EventName::kRestartScheduled}) {
    if (progress.event == NameOf(counted)) return progress.event;
  }
  return progress.event + " " + std::to_string(progress.code) + " " +
         WithoutChangingNumbers(progress.message);
}

bool IsPowerOfTen(int number) {
  while (number >= 10 && number % 10 == 0) number /= 10;
  return number == 1;
}

// Why an actuator is degraded; empty: the line does not say.
std::string ReasonIn(const std::string& message) {
  constexpr std::string_view kBefore = " is degraded: ";
  const std::size_t at = message.find(kBefore);
  return at == std::string::npos ? "" : message.substr(at + kBefore.size());
}

Progress SummaryOf(const Progress& of, int times) {
  Progress summary = of;
  summary.code = 0;
  summary.message =
      of.actuator + ": repeated " + (times == 1 ? "once" : std::to_string(times) + " times");
  return summary;
}

}  // namespace

std::vector<Progress> Repetitions::Take(const Progress& progress) {
  std::vector<Progress> lines = NewLines(progress);
  for (Progress& line : lines) Shorten(line);
  return lines;
}

void Repetitions::Shorten(Progress& line) {
  const std::string reason = ReasonIn(line.message);
  std::erase_if(reasons_, [&](const Reason& r) { return line.wall_ns - r.at_ns > kInSightNs; });
  const Reason* longest = nullptr;
  for (const Reason& r : reasons_) {
    if (!line.actuator.empty() && line.actuator != r.actuator) continue;
    const bool longer = longest == nullptr || r.text.size() > longest->text.size();
    if (longer && line.message.find(r.text) != std::string::npos) longest = &r;
  }
  if (longest != nullptr) {
    line.message.replace(line.message.find(longest->text), longest->text.size(), "as above");
  }
  if (reason.size() < kShortReason) return;
  if (reasons_.size() == kMostReasons) reasons_.erase(reasons_.begin());
  reasons_.push_back({line.actuator, reason, line.wall_ns});
}

std::vector<Progress> Repetitions::NewLines(const Progress& progress) {
  if (progress.actuator.empty()) {
    // The lines of a switch are not those of a crash.
    if (progress.kind == "switch") loops_.clear();
    return {progress};
  }
  Loop& loop = loops_[progress.actuator];
  if (progress.wall_ns - loop.last_ns > kForgetAfterNs) loop = {};
  loop.last_ns = progress.wall_ns;
  const std::string said = KeyOf(progress);
  const bool restart = progress.event == NameOf(EventName::kRestartScheduled);
  if (loop.restarted && loop.said.contains(said)) {
    if (!restart) return {};
    ++loop.times;
    return loop.times >= 10 && IsPowerOfTen(loop.times)
               ? std::vector<Progress>{SummaryOf(progress, loop.times)}
               : std::vector<Progress>{};
  }
  std::vector<Progress> lines;
  if (loop.times > 0) lines.push_back(SummaryOf(progress, loop.times));
  if (loop.restarted) loop = {progress.wall_ns, {}, false, 0};  // a new failure: print all lines
  lines.push_back(progress);
  loop.said.insert(said);
  loop.restarted |= restart;
  return lines;
}

}  // namespace musher::cli
