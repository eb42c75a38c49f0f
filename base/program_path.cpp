#include "musher/base/program_path.hpp"

#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <system_error>

namespace musher {

std::filesystem::path OwnProgram() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error);  // empty on an error
}

std::string SearchPath() {
  const char* path = std::getenv("PATH");  // NOLINT(concurrency-mt-unsafe)
  return path != nullptr ? path : "/usr/local/bin:/usr/bin:/bin";
}

void PutFirstInPath(const std::string& folder) {
  setenv("PATH", (folder + ":" + SearchPath()).c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
}

namespace {

std::vector<std::string_view> FoldersOf(std::string_view path) {
  std::vector<std::string_view> folders;
  while (true) {
    const std::size_t end = path.find(':');
    folders.push_back(path.substr(0, end));
    if (end == std::string_view::npos) return folders;
    path.remove_prefix(end + 1);
  }
}

}  // namespace

std::vector<std::string> CandidatesInPath(std::string_view program, std::string_view path) {
  std::vector<std::string> candidates;
  for (const std::string_view folder : FoldersOf(path)) {
    candidates.push_back(std::string(folder.empty() ? "." : folder).append("/").append(program));
  }
  return candidates;
}

std::string FindInPath(std::string_view program, std::string_view path) {
  for (const std::string_view folder : FoldersOf(path)) {
    if (folder.empty()) continue;
    std::string candidate = std::string(folder).append("/").append(program);
    std::error_code error;
    const bool is_file = std::filesystem::is_regular_file(candidate, error);
    if (is_file && access(candidate.c_str(), X_OK) == 0) return candidate;
  }
  return {};
}

}  // namespace musher
