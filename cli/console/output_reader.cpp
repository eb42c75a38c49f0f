#include "musher/cli/console/output_reader.hpp"

#include <fcntl.h>
#include <sys/stat.h>

namespace musher::cli {

// The writing end of a pipe is never readable, but epoll reports its error with every request.
UniqueFd TakeReaderOf(int output) {
  struct stat file {};
  if (fstat(output, &file) != 0 || !S_ISFIFO(file.st_mode)) return {};
  if ((fcntl(output, F_GETFL) & O_ACCMODE) != O_WRONLY) return {};
  return UniqueFd(fcntl(output, F_DUPFD_CLOEXEC, 0));
}

}  // namespace musher::cli
