#include "musher/modules/motion/toml_file.hpp"

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

namespace musher::motion {
namespace {

constexpr std::uintmax_t kLargestFile = 1U << 20;

}  // namespace

Result<std::string> ReadText(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    return Error{kCodeParametersInvalid, "it is a folder"};
  }
  if (std::filesystem::file_size(path, error) > kLargestFile && !error) {
    return Error{kCodeParametersInvalid, "it is larger than 1 MiB"};
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return Error{kCodeParametersInvalid, errno != 0 ? std::strerror(errno) : "it cannot be opened"};
  }
  return std::string(std::istreambuf_iterator<char>(file), {});
}

Diagnostic Unreadable(const std::string& path, const std::string& reason) {
  return {path, 0, 0, Severity::kError, "the file cannot be read: " + reason};
}

}  // namespace musher::motion
