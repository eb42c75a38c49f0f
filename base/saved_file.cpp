#include "musher/base/saved_file.hpp"

#include <filesystem>
#include <mutex>
#include <utility>

#include "musher/base/files.hpp"

namespace musher {
namespace {

constexpr Duration kLongestSave = Milliseconds(100);
constexpr Duration kLongestSaveEnd = Milliseconds(1000);

}  // namespace

struct SavedFile::State {
  std::mutex mutex;  // guards what follows
  bool late = false;
  Result<> last;
};

SavedFile::SavedFile(std::string path, AfterFailure after)
    : path_(std::move(path)), after_(after), state_(std::make_shared<State>()) {}

Result<> SavedFile::Replace(std::string content) {
  return Do([path = path_, after = after_, content = std::move(content)]() -> Result<> {
    std::error_code ignored;
    std::filesystem::create_directories(std::filesystem::path(path).parent_path(), ignored);
    Result<> written = ReplaceFile(path, content, {.synced = false});
    if (!written && after == AfterFailure::kRemoved) std::filesystem::remove(path, ignored);
    return written;
  });
}

void SavedFile::Remove() {
  static_cast<void>(Do([path = path_]() -> Result<> {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    return Ok();
  }));
}

Result<> SavedFile::Do(std::function<Result<>()> work) {
  if (!queue_) {
    queue_.emplace(WorkQueueOptions{
        .name = "saved-file", .takes_signals = false, .end_timeout = kLongestSaveEnd});
  }
  queue_->Do(
      [state = state_, work = std::move(work)] {
        const Result<> done = work();
        const std::lock_guard lock(state->mutex);
        state->last = done;
        state->late = false;
      },
      {.key = "file"});
  const auto is_late = [this] {
    const std::lock_guard lock(state_->mutex);
    return state_->late;
  };
  const bool done = !is_late() && queue_->Flush(kLongestSave);
  const std::lock_guard lock(state_->mutex);
  if (done) return state_->last;
  state_->late = true;
  return Error{kCodeFailed, "can't write " + path_ + ": the disk has not answered yet"};
}

}  // namespace musher
