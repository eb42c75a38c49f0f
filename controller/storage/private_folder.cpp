#include "musher/controller/storage/private_folder.hpp"

#include <sys/stat.h>

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

}  // namespace musher
