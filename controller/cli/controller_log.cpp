#include "musher/controller/cli/controller_log.hpp"

#include <fcntl.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>

#include "musher/transport/unique_fd.hpp"

namespace musher::cli {
namespace {

constexpr std::uintmax_t kLargestLog = 16 << 20;  // bytes; at a start, a larger one is put aside

void PutAsideIfLarge(const std::string& path) {
  std::error_code missing;
  const auto size = std::filesystem::file_size(path, missing);
  if (!missing && size > kLargestLog) std::filesystem::rename(path, path + ".1", missing);
}

// What libraries and a crash say must not be lost either.
void TakeStandardOutput(const std::string& path) {
  const transport::UniqueFd file(open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC));
  const transport::UniqueFd nowhere(open("/dev/null", O_RDWR | O_CLOEXEC));
  const int target = file.valid() ? file.get() : nowhere.get();
  for (const int fd : {STDOUT_FILENO, STDERR_FILENO}) dup2(target, fd);
}

}  // namespace

ControllerLog::~ControllerLog() = default;

void ControllerLog::Open() {
  opened_ = true;
  try {
    PutAsideIfLarge(path_);
    logger_ = std::make_shared<spdlog::logger>(
        "controller", std::make_shared<spdlog::sinks::basic_file_sink_mt>(path_));
    logger_->set_pattern("%Y-%m-%d %H:%M:%S.%e %l: %v");
    logger_->flush_on(spdlog::level::info);
  } catch (const spdlog::spdlog_ex& e) {
    std::fprintf(stderr, "musher: no log: %s\n", e.what());
  }
  TakeStandardOutput(path_);
}

void ControllerLog::Write(std::string_view line, std::int32_t code) {
  if (!opened_) Open();
  if (!logger_) return;
  logger_->log(code == kCodeOk ? spdlog::level::info : spdlog::level::warn, "{}",
               WithCode(std::string(line), code));
}

}  // namespace musher::cli
