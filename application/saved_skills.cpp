#include "musher/application/saved_skills.hpp"

#include <filesystem>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/behavior/skill/snapshot.hpp"
#include "musher/behavior/skill/toml/snapshot_toml.hpp"

namespace musher {
namespace {

constexpr Duration kWrittenEach = std::chrono::seconds(1);
constexpr std::size_t kLargest = 16 << 20;
constexpr const char* kKilled = "its process has ended while it ran";

bool Ended(const std::string& state) {
  return state == "SUCCEEDED" || state == "FAILED" || state == "CANCELLED";
}

// The run as it had failed then, and so the skills inside of it.
void Fail(skill::Snapshot& run) {
  if (Ended(run.state) || run.state == "IDLE") return;
  const std::string why = std::string(kKilled) + " (" + run.state + ")";
  run.history.push_back({run.time, run.ticks, run.state, "FAILED", skill::Cause::kFault, why});
  run.errors.push_back({run.time, run.state, why});
  run.state = "FAILED";
  run.message = why;
  run.paused = run.pause_requested = false;
  for (skill::Snapshot& inside : run.inside) Fail(inside);
}

}  // namespace

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
  std::error_code ignored;
  std::filesystem::create_directories(std::filesystem::path(file_).parent_path(), ignored);
  const Result<> written =
      text ? ReplaceFile(file_, text.value(), {.synced = false}) : Result<>(text.error());
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
  const Result<std::string> text = config_toml::ReadTextFile(file_, kLargest);
  if (!text) return text.error();
  if (const Result<> read = skill::RestoreSnapshot(manager, text.value(), file_); !read) {
    return read.error();
  }
  if (!continues) {
    Result<skill::ManagerSnapshot> saved = manager.Save();
    if (!saved) return saved.error();
    manager.ResetAll();  // before its outputs are open: nothing is sent
    for (skill::Snapshot& run : saved.value().runs) Fail(run);
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

}  // namespace musher
