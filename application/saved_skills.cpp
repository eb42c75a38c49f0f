#include "musher/application/saved_skills.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <sstream>
#include <string_view>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/behavior/skill/snapshot.hpp"
#include "musher/behavior/skill/toml/snapshot_toml.hpp"

namespace musher {
namespace {

constexpr Duration kWrittenEach = std::chrono::seconds(1);
constexpr std::size_t kLargest = 16 << 20;
constexpr const char* kKilled = "its process has ended while it ran";
constexpr std::size_t kMostStops = 256;
// The first three lines of the file.
constexpr std::string_view kHostLine = "written_host = \"";
constexpr std::string_view kTimeLine = "written_ns = ";
constexpr std::string_view kStopsLine = "stops = \"";

bool Ended(const std::string& state) {
  return state == "SUCCEEDED" || state == "FAILED" || state == "CANCELLED";
}

std::string TextOf(const SavedSkills::Written& written) {
  std::string text = std::string(kHostLine) + written.at.host + "\"\n" + std::string(kTimeLine) +
                     std::to_string(written.at.since_boot.count()) + "\n" + std::string(kStopsLine);
  for (const std::string& stop : written.stops) text += stop + ' ';
  return text + "\"\n\n";
}

// What is between the begin of a line and a quote at its end. Nullopt: it is another line.
std::optional<std::string_view> Quoted(std::string_view line, std::string_view begin) {
  if (!line.starts_with(begin) || line.size() <= begin.size() || !line.ends_with('"')) {
    return std::nullopt;
  }
  return line.substr(begin.size(), line.size() - begin.size() - 1);
}

// Reads the first three lines and leaves them empty, so that errors name the lines of the file.
// Nullopt: the file does not have them.
std::optional<SavedSkills::Written> TakeWritten(std::string& text) {
  std::array<std::string_view, 3> lines;
  std::size_t begin = 0;
  for (std::string_view& line : lines) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string::npos) return std::nullopt;
    line = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
  }
  const auto host = Quoted(lines[0], kHostLine);
  const auto stops = Quoted(lines[2], kStopsLine);
  if (!host || !lines[1].starts_with(kTimeLine) || !stops) return std::nullopt;
  const std::string_view time = lines[1].substr(kTimeLine.size());
  std::int64_t since_boot_ns = 0;
  const auto read = std::from_chars(time.data(), time.data() + time.size(), since_boot_ns);
  if (read.ec != std::errc() || read.ptr != time.data() + time.size()) return std::nullopt;
  SavedSkills::Written written{{std::string(*host), Duration(since_boot_ns)}, {}};
  std::istringstream words{std::string(*stops)};
  for (std::string stop; words >> stop;) written.stops.insert(stop);
  text.replace(0, begin, "\n\n\n");
  return written;
}

// Why what ran then does not go on now; empty: it does.
std::string WhyOver(const std::optional<SavedSkills::Written>& written, const HostTime& now) {
  if (!written) return "its file does not say when it was written";
  const Duration age = now.since_boot - written->at.since_boot;
  if (written->at.host.empty() || written->at.host != now.host || age < Duration{}) {
    return "the computer or its container was restarted since then";
  }
  if (age <= SavedSkills::kMostAge) return "";
  const auto seconds = [](Duration time) {
    return std::to_string(std::chrono::duration_cast<std::chrono::seconds>(time).count()) + " s";
  };
  return "it was saved " + seconds(age) + " ago, and " + seconds(SavedSkills::kMostAge) +
         " are the limit";
}

// The run as it had failed then, and so the skills inside of it. `over`: see WhyOver().
void Fail(skill::Snapshot& run, const std::string& over) {
  if (Ended(run.state) || run.state == "IDLE") return;
  const std::string why = std::string(kKilled) + " (" + run.state + ")" +
                          (over.empty() ? "" : "; it does not go on: " + over);
  run.history.push_back({run.time, run.ticks, run.state, "FAILED", skill::Cause::kFault, why});
  run.errors.push_back({run.time, run.state, why});
  run.state = "FAILED";
  run.message = why;
  run.paused = run.pause_requested = false;
  for (skill::Snapshot& inside : run.inside) Fail(inside, over);
}

}  // namespace

HostTime HostTimeNow() {
  return {HostId(), Duration(static_cast<std::int64_t>(NewIncarnation()))};
}

Result<> SavedSkills::Save(const skill::Manager& manager, Time now) {
  std::string shown;
  for (const skill::Run* run : manager.Runs()) {
    if (!run->running()) continue;
    shown += run->name() + " " + run->Path() + (run->pause_requested() ? " paused\n" : "\n");
  }
  const bool due =
      !shown.empty() && (!written_at_ || now < *written_at_ || now - *written_at_ >= kWrittenEach);
  if (shown == shown_ && !due) return Ok();
  Result<skill::ManagerSnapshot> saved = manager.Save();
  if (saved) {
    std::erase_if(saved.value().runs, [](const auto& run) { return Ended(run.state); });
  }
  const Result<std::string> text =
      saved ? skill::WriteSnapshot(saved.value()) : Result<std::string>(saved.error());
  const Result<> written =
      text ? saved_.Replace(TextOf(restored_.value_or(Written{host_now_(), stops_})) + text.value())
           : Result<>(text.error());
  if (!text) saved_.Remove();
  written_at_ = now;
  shown_ = std::move(shown);
  const std::string fault = written ? "" : written.error().message;
  if (std::exchange(fault_, fault) == fault || written) return Ok();
  return Error{kCodeFailed, "the skills that run are not saved: " + fault};
}

Result<std::vector<std::string>> SavedSkills::Restore(skill::Manager& manager, bool continues) {
  std::vector<std::string> lines;
  std::error_code none;
  if (!std::filesystem::exists(file_, none)) return lines;
  Result<std::string> text = config_toml::ReadTextFile(file_, kLargest);
  if (!text) return text.error();
  const std::optional<Written> written = TakeWritten(text.value());
  if (const Result<> read = skill::RestoreSnapshot(manager, text.value(), file_); !read) {
    return read.error();
  }
  const std::string over = continues ? WhyOver(written, host_now_()) : "";
  continues = continues && over.empty();
  if (continues) restored_ = written;
  if (!continues) {
    Result<skill::ManagerSnapshot> saved = manager.Save();
    if (!saved) return saved.error();
    manager.ResetAll();  // before its outputs are open: nothing is sent
    for (skill::Snapshot& run : saved.value().runs) Fail(run, over);
    const auto faults = manager.Restore(saved.value());
    if (!faults.empty()) return Error{kCodeFailed, faults.front().key + ": " + faults.front().what};
  }
  for (const skill::Run* run : manager.Runs()) {
    const std::string goes_on = run->pause_requested()
                                    ? " stays paused in " + run->Path() + " until it is resumed"
                                    : " goes on from " + run->Path() + " once it is Active";
    lines.push_back(run->name() +
                    (continues ? goes_on : " has failed: " + run->feedback().message));
  }
  return lines;
}

void SavedSkills::NoteStop(std::uint64_t id, bool engaged) {
  stops_.insert(std::to_string(id) + (engaged ? "+" : "-"));
  if (stops_.size() > kMostStops) stops_.erase(stops_.begin());
}

std::string SavedSkills::TakeOver() {
  const auto restored = std::exchange(restored_, std::nullopt);
  if (!restored) return "";
  if (!std::includes(restored->stops.begin(), restored->stops.end(), stops_.begin(),
                     stops_.end())) {
    return "an emergency stop has come since it was saved";
  }
  return WhyOver(restored, host_now_());
}

}  // namespace musher
