#include "musher/application/recording_file.hpp"

#include <fcntl.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "musher/base/files.hpp"

namespace musher {
namespace {

constexpr std::chrono::seconds kSyncEvery(1);

bool IsWorthKeeping(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) return false;
  return !line.starts_with("musher-") || std::getline(file, line);
}

}  // namespace

bool RecordingFile::Open() {
  std::error_code none;
  if (std::filesystem::is_regular_file(path_, none) && IsWorthKeeping(path_)) {
    std::filesystem::rename(path_, path_ + ".before", none);
  }
  fd_ = UniqueFd(open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  return fd_.valid();
}

bool RecordingFile::Write(std::string_view text) {
  if (!fd_.valid() || !WriteAll(fd_.get(), text)) return false;
  const auto now = std::chrono::steady_clock::now();
  if (now - synced_ < kSyncEvery) return true;
  synced_ = now;
  return fdatasync(fd_.get()) == 0 || errno == EINVAL || errno == EROFS;  // of a pipe: EINVAL
}

}  // namespace musher
