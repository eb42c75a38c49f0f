// A stalling disk, for a process that preloads this library: writes below the folder
// $MUSHER_STALL_BELOW wait while the file $MUSHER_STALL_WHILE exists, at most 30 s. As on a real
// disk, the waiting calls cannot be interrupted, and all others continue.

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

constexpr int kStepMs = 1;
constexpr int kMostSteps = 30'000;

// Read once, so that the calls below are as safe between fork and exec as those they replace.
std::array<char, 4096> below{};
std::array<char, 4096> stall{};

__attribute__((constructor)) void ReadEnvironment() {
  const auto copy = [](std::array<char, 4096>& to, const char* name) {
    const char* value = std::getenv(name);
    if (value != nullptr) std::strncpy(to.data(), value, to.size() - 1);
  };
  copy(below, "MUSHER_STALL_BELOW");
  copy(stall, "MUSHER_STALL_WHILE");
}

bool Stalls() {
  return stall[0] != '\0' && below[0] != '\0' && access(stall.data(), F_OK) == 0;
}

void Wait() {
  for (int step = 0; step < kMostSteps && Stalls(); ++step) {
    poll(nullptr, 0, kStepMs);
  }
}

bool IsBelow(const char* path) {
  return path != nullptr && std::strncmp(path, below.data(), std::strlen(below.data())) == 0;
}

void WaitFor(const char* path) {
  if (Stalls() && IsBelow(path)) Wait();
}

void WaitFor(int fd) {
  if (!Stalls()) return;
  std::array<char, 32> link{};
  std::array<char, 4096> path{};
  std::snprintf(link.data(), link.size(), "/proc/self/fd/%d", fd);
  if (readlink(link.data(), path.data(), path.size() - 1) > 0 && IsBelow(path.data())) Wait();
}

int Open(int folder, const char* path, int flags, va_list arguments) {
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
  if ((flags & O_ACCMODE) != O_RDONLY) WaitFor(path);
  return static_cast<int>(syscall(SYS_openat, folder, path, flags, mode));
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const int fd = Open(AT_FDCWD, path, flags, arguments);
  va_end(arguments);
  return fd;
}

int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const int fd = Open(AT_FDCWD, path, flags | O_LARGEFILE, arguments);
  va_end(arguments);
  return fd;
}

int openat(int folder, const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const int fd = Open(folder, path, flags, arguments);
  va_end(arguments);
  return fd;
}

ssize_t write(int fd, const void* data, size_t size) {
  WaitFor(fd);
  return syscall(SYS_write, fd, data, size);
}

ssize_t pwrite64(int fd, const void* data, size_t size, off64_t at) {
  WaitFor(fd);
  return syscall(SYS_pwrite64, fd, data, size, at);
}

int fsync(int fd) {
  WaitFor(fd);
  return static_cast<int>(syscall(SYS_fsync, fd));
}

int fdatasync(int fd) {
  WaitFor(fd);
  return static_cast<int>(syscall(SYS_fdatasync, fd));
}

int rename(const char* from, const char* to) {
  WaitFor(to);
  return static_cast<int>(syscall(SYS_renameat, AT_FDCWD, from, AT_FDCWD, to));
}

int unlink(const char* path) {
  WaitFor(path);
  return static_cast<int>(syscall(SYS_unlinkat, AT_FDCWD, path, 0));
}

int mkdir(const char* path, mode_t mode) {
  WaitFor(path);
  return static_cast<int>(syscall(SYS_mkdirat, AT_FDCWD, path, mode));
}

int ftruncate64(int fd, off64_t size) {
  WaitFor(fd);
  return static_cast<int>(syscall(SYS_ftruncate, fd, size));
}

int ftruncate(int fd, off_t size) {
  return ftruncate64(fd, size);
}

}  // extern "C"
