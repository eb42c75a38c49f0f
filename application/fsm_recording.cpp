#include "musher/application/fsm_recording.hpp"

#include <filesystem>
#include <system_error>
#include <utility>

namespace musher {

Result<std::unique_ptr<FsmRecording>> FsmRecording::Open(fsm::Machine& machine,
                                                         const std::string& file,
                                                         std::string_view key, Log log) {
  std::error_code none;
  if (std::filesystem::is_regular_file(file, none)) {
    std::filesystem::rename(file, file + ".before", none);
  }
  std::ofstream stream(file);
  if (!stream.good()) {
    return Error{kCodeFailed, std::string(key) + ": " + file + " cannot be written to"};
  }
  return std::unique_ptr<FsmRecording>(
      new FsmRecording(machine, std::move(stream), std::move(log)));
}

FsmRecording::FsmRecording(fsm::Machine& machine, std::ofstream stream, Log log)
    : stream_(std::move(stream)),
      log_(std::move(log)),
      recorder_(machine, [this](std::string_view line) { Write(line); }) {}

void FsmRecording::Write(std::string_view line) {
  if (!stream_.good()) return;
  stream_ << line;
  if (line.starts_with("changed")) stream_.flush();
  if (!stream_.good()) log_("the recording ends here: its file cannot be written to");
}

}  // namespace musher
