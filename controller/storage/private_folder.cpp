#include "musher/controller/storage/private_folder.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>

#include "musher/base/host.hpp"

namespace musher {

Result<> MakePrivateFolder(const std::filesystem::path& path) {
  std::filesystem::path so_far;
  for (const auto& part : path) {
    so_far /= part;
    if (so_far.empty() || part == "." || part == "..") continue;
    if (mkdir(so_far.c_str(), 0700) == 0) continue;
    const int error_number = errno;
    std::error_code unknown;
    if (!std::filesystem::is_directory(so_far, unknown)) {
      return SystemError("can't make the folder " + so_far.string(),
                         error_number == EEXIST ? ENOTDIR : error_number);
    }
  }
  return Ok();
}

bool IsLink(const std::filesystem::path& path) {
  struct stat info {};
  return lstat(path.c_str(), &info) == 0 && S_ISLNK(info.st_mode);
}

bool LogMayBeLink(const std::string& log, const std::string& state_dir) {
  if (log.empty()) return false;
  std::error_code unknown;
  const auto folder =
      std::filesystem::weakly_canonical(std::filesystem::path(log).parent_path(), unknown);
  if (unknown) return false;
  const auto state = std::filesystem::weakly_canonical(state_dir, unknown);
  return !unknown &&
         std::mismatch(state.begin(), state.end(), folder.begin(), folder.end()).first !=
             state.end();
}

}  // namespace musher
