#include "musher/view/live/log_text.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "musher/base/unique_fd.hpp"

namespace musher::view {

Result<LogPiece> ReadLog(const std::string& path, std::int64_t from) {
  const UniqueFd fd(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat status {};
  if (!fd.valid() || fstat(fd.get(), &status) != 0) {
    const std::string why = std::strerror(errno);  // NOLINT(concurrency-mt-unsafe)
    return Error{kCodeFailed, "the log " + path + " cannot be read: " + why};
  }
  LogPiece piece;
  piece.size = status.st_size;
  const bool cut = from < 0 && piece.size + from > 0;
  piece.from = from < 0 ? std::max<std::int64_t>(0, piece.size + from) : from;
  if (piece.from > piece.size) piece.from = 0;
  const std::int64_t count = std::min(kMostLogBytes, piece.size - piece.from);
  piece.text.resize(static_cast<std::size_t>(count));
  const ssize_t got = pread(fd.get(), piece.text.data(), piece.text.size(), piece.from);
  piece.text.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
  piece.to = piece.from + static_cast<std::int64_t>(piece.text.size());
  if (cut) {
    const std::size_t line = piece.text.find('\n');
    if (line != std::string::npos) {
      piece.text.erase(0, line + 1);
      piece.from += static_cast<std::int64_t>(line) + 1;
    }
  }
  return piece;
}

}  // namespace musher::view
