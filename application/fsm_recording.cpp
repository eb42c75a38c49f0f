#include "musher/application/fsm_recording.hpp"

#include <utility>

#include "musher/application/recording_file.hpp"

namespace musher {
namespace {

constexpr std::size_t kGivenAtOnce = 4096;  // bytes

}  // namespace

Result<std::unique_ptr<FsmRecording>> FsmRecording::Open(fsm::Machine& machine,
                                                         const std::string& file,
                                                         std::string_view key, Log log,
                                                         std::size_t most_bytes) {
  const auto opened = std::make_shared<RecordingFile>(file);
  if (!opened->Open()) {
    return Error{kCodeFailed, std::string(key) + ": " + file + " cannot be written to"};
  }
  return std::unique_ptr<FsmRecording>(
      new FsmRecording(machine, most_bytes, opened, std::move(log)));
}

FsmRecording::FsmRecording(fsm::Machine& machine, std::size_t most_bytes,
                           std::shared_ptr<RecordingFile> file, Log log)
    : most_bytes_(most_bytes),
      log_(std::move(log)),
      file_(std::move(file)),
      recorder_(machine, [this](std::string_view line) { Write(line); }) {}

FsmRecording::~FsmRecording() {
  Give();
}

void FsmRecording::Write(std::string_view line) {
  if (ended_ || file_->failed) return;
  if (bytes_ + line.size() > most_bytes_) {
    return End("it has " + std::to_string(most_bytes_ >> 20) + " MiB, as much as it may have");
  }
  if (file_->pending > kMostPending) return End("the disk is too slow");
  bytes_ += line.size();
  buffer_ += line;
  if (line.starts_with("changed") || buffer_.size() >= kGivenAtOnce) Give();
}

void FsmRecording::End(const std::string& why) {
  Give();
  ended_ = true;
  log_("the recording ends here: " + why);
}

void FsmRecording::Give() {
  if (buffer_.empty()) return;
  file_->pending += buffer_.size();
  thread_.Do([file = file_, log = log_, text = std::exchange(buffer_, {})] {
    if (!file->failed && !file->Write(text)) {
      file->failed = true;
      log("the recording ends here: its file cannot be written to");
    }
    file->pending -= text.size();
  });
}

}  // namespace musher
