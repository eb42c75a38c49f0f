#include "musher/base/files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <fstream>

#include "musher/base/host.hpp"

namespace musher {

std::string ReadFile(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string bytes;
  // The kernel reads an environment as of one moment, if it is read at once.
  std::vector<char> chunk(std::size_t{1} << 16U);
  while (stream) {
    stream.read(chunk.data(), static_cast<std::streamsize>(chunk.size()));
    bytes.append(chunk.data(), static_cast<std::size_t>(stream.gcount()));
  }
  return stream.bad() ? std::string() : bytes;
}

// A device may act once it is opened, so it is looked at first; and again, as it may be replaced
// meanwhile.
UniqueFd OpenRegular(const std::string& path) {
  struct stat info {};
  if (lstat(path.c_str(), &info) != 0) return {};
  if (!S_ISREG(info.st_mode)) {
    errno = EINVAL;
    return {};
  }
  UniqueFd file(open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (!file.valid()) return {};
  if (fstat(file.get(), &info) == 0 && S_ISREG(info.st_mode)) return file;
  errno = EINVAL;
  return {};
}

Result<> WriteFile(const std::string& path, std::string_view content) {
  constexpr mode_t kMode = 0666;  // as the umask permits
  UniqueFd file(open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kMode));
  if (!file.valid() || !WriteAll(file.get(), content) || !file.Close()) {
    return SystemError("can't write " + path);
  }
  return Ok();
}

bool WriteAll(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(fd, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written == 0) errno = ENOSPC;
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

Result<> ReplaceFile(const std::string& path, std::string_view content,
                     const ReplaceOptions& options) {
  const std::string draft = path + options.draft;
  const auto failed = [&] {
    Error error = SystemError("can't save " + path);
    unlink(draft.c_str());
    return error;
  };
  UniqueFd file(
      open(draft.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, options.mode));
  if (!file.valid() || !WriteAll(file.get(), content)) return failed();
  if (options.synced && fsync(file.get()) != 0) return failed();
  if (!file.Close() || rename(draft.c_str(), path.c_str()) != 0) return failed();
  if (!options.synced) return Ok();
  return SyncFolder(std::filesystem::path(path).parent_path()) ? Ok() : Result<>(failed());
}

bool SyncFolder(const std::string& folder) {
  const char* path = folder.empty() ? "." : folder.c_str();
  const UniqueFd fd(open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return fd.valid() && fsync(fd.get()) == 0;
}

std::vector<std::filesystem::path> EntriesOf(const std::filesystem::path& folder,
                                             std::error_code& error) {
  std::vector<std::filesystem::path> entries;
  std::filesystem::directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    entries.push_back(entry->path());
  }
  return entries;
}

std::vector<std::filesystem::path> EntriesOf(const std::filesystem::path& folder) {
  std::error_code ignored;
  return EntriesOf(folder, ignored);
}

}  // namespace musher
