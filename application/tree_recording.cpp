#include "musher/application/tree_recording.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include "musher/application/recording_file.hpp"

namespace musher {
namespace {

std::uint64_t WallUs() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

}  // namespace

Result<std::unique_ptr<TreeRecording>> TreeRecording::Open(const std::string& actuator,
                                                           const TreeRecordingOptions& options,
                                                           Log log) {
  const auto file = std::make_shared<RecordingFile>(options.file);
  const std::filesystem::path folder = std::filesystem::path(options.file).parent_path();
  std::error_code none;
  if (!folder.empty()) std::filesystem::create_directories(folder, none);
  if (!file->Open()) {
    return Error{kCodeFailed, "the recording " + options.file + " cannot be written to: " +
                                  std::error_code(errno, std::generic_category()).message()};
  }
  return std::unique_ptr<TreeRecording>(
      new TreeRecording(actuator, options.most_bytes, file, std::move(log)));
}

TreeRecording::TreeRecording(std::string actuator, std::size_t most_bytes,
                             std::shared_ptr<RecordingFile> file, Log log)
    : actuator_(std::move(actuator)),
      most_in_file_(most_bytes / 2),
      log_(std::move(log)),
      recorder_(
          std::make_shared<tree::Recorder>([this](std::string_view lines) { buffer_ += lines; })),
      file_(std::move(file)) {
  recorder_->Head(actuator_);
}

// The tree may outlive this.
TreeRecording::~TreeRecording() {
  End();
}

void TreeRecording::Begin(const TreeView& view, const tree::Factory& factory) {
  End();
  if (view.tree == nullptr || file_->failed) return;
  recorder_->Begin({.tree = view.tree,
                    .document = view.document,
                    .factory = &factory,
                    .revision = view.revision,
                    .time = [time = view.time](Time at) { return time->At(at); }},
                   WallUs());
  if (!Fits()) return;
  view.tree->Listen(recorder_);
  Note(view);
}

void TreeRecording::End() {
  Flush();
  recorder_->End();
}

void TreeRecording::Note(const TreeView& view) {
  recorder_->Note({.at = view.time->last(),
                   .wall_us = WallUs(),
                   .ticking = view.ticking,
                   .result = view.result,
                   .fault = *view.last_fault});
  Flush();
}

void TreeRecording::Flush() {
  if (buffer_.empty()) return;
  if (file_->failed) return buffer_.clear();
  if (lost_ > 0 || file_->pending > kMostPending) {
    lost_ += static_cast<std::uint64_t>(std::ranges::count(buffer_, '\n'));
    buffer_.clear();
    if (file_->pending > kMostPending / 2) return;
    recorder_->Lost(std::exchange(lost_, 0));
    recorder_->BeginAgain(WallUs());
  }
  const bool full = written_ + buffer_.size() > most_in_file_;
  Give();
  if (!full) return;
  BeginFile();
  recorder_->BeginAgain(WallUs());
  if (Fits()) Give();
}

void TreeRecording::BeginFile() {
  Give();
  written_ = 0;
  recorder_->Head(actuator_);
  thread_.Do([file = file_, log = log_] {
    if (file->failed || file->Open()) return;
    file->failed = true;
    log("the recording ends here: " + file->path() + " cannot be written to");
  });
}

// Whether what describes a new file or tree fits into a recording.
bool TreeRecording::Fits() {
  if (written_ + buffer_.size() <= most_in_file_ || buffer_.size() <= most_in_file_ / 2)
    return true;
  log_("the tree is not recorded: its description has " + std::to_string(buffer_.size()) +
       " bytes, more than a half of the recording may have");
  buffer_.clear();
  recorder_->End();
  return false;
}

void TreeRecording::Give() {
  if (buffer_.empty()) return;
  written_ += buffer_.size();
  file_->pending += buffer_.size();
  thread_.Do([file = file_, log = log_, text = std::exchange(buffer_, {})] {
    if (!file->failed && !file->Write(text)) {
      file->failed = true;
      log("the recording ends here: " + file->path() + " cannot be written to");
    }
    file->pending -= text.size();
  });
}

}  // namespace musher
