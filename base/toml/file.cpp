#include "musher/base/toml/file.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace musher::config_toml {

Result<std::string> ReadTextFile(const std::string& path, std::size_t most) {
  const auto unreadable = [](const std::string& reason) {
    return Error{kCodeParametersInvalid, "the file cannot be read: " + reason};
  };
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return unreadable("it is a folder");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) return unreadable(errno != 0 ? std::strerror(errno) : "it cannot be opened");
  std::string text;
  std::array<char, 16'384> chunk{};
  while (file && text.size() <= most) {
    file.read(chunk.data(), chunk.size());
    text.append(chunk.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad()) return unreadable("reading failed");
  if (text.size() > most) text.resize(most + 1);
  return text;
}

Result<std::string> ReadModuleText(const std::string& path) {
  constexpr std::size_t kLargest = 1U << 20;
  Result<std::string> text = ReadTextFile(path, kLargest);
  if (text && text.value().size() > kLargest) {
    return Error{kCodeParametersInvalid, "the file is larger than 1 MiB"};
  }
  return text;
}

}  // namespace musher::config_toml
