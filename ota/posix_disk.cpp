#include "musher/ota/posix_disk.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <climits>
#include <cstdio>
#include <filesystem>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/ota/fault.hpp"

namespace musher::ota {
namespace {

// Limit for a stopped lock holder: a robot's start must not wait for ever.
constexpr int kTries = 500;
constexpr int kTryEveryMs = 20;

// A full disk has a code of its own.
Error DiskError(const std::string& what) {
  const bool full = errno == ENOSPC || errno == EDQUOT || errno == EFBIG;
  Error error = SystemError(what);
  return full ? FaultError(Fault::kNoSpace, error.message) : error;
}

class PosixReader : public Disk::Reader {
 public:
  PosixReader(std::string path, UniqueFd fd) : path_(std::move(path)), fd_(std::move(fd)) {}

  Result<std::string_view> Read(std::size_t most) override {
    buffer_.resize(most);
    ssize_t size = 0;
    do {
      size = read(fd_.get(), buffer_.data(), buffer_.size());
    } while (size < 0 && errno == EINTR);
    if (size < 0) return SystemError("can't read " + path_);
    return std::string_view(buffer_.data(), static_cast<std::size_t>(size));
  }

 private:
  std::string path_;
  UniqueFd fd_;
  std::string buffer_;
};

class PosixWriter : public Disk::Writer {
 public:
  PosixWriter(std::string path, UniqueFd fd) : path_(std::move(path)), fd_(std::move(fd)) {}

  Result<> Write(std::string_view bytes) override {
    while (!bytes.empty()) {
      const ssize_t size = write(fd_.get(), bytes.data(), bytes.size());
      if (size < 0 && errno == EINTR) continue;
      if (size < 0) return DiskError("can't write " + path_);
      bytes.remove_prefix(static_cast<std::size_t>(size));
    }
    return Ok();
  }

 private:
  std::string path_;
  UniqueFd fd_;
};

class PosixLock : public Disk::Lock {
 public:
  explicit PosixLock(UniqueFd fd) : fd_(std::move(fd)) {}

  int KeepForExec() override {
    fcntl(fd_.get(), F_SETFD, 0);
    return fd_.get();
  }

 private:
  UniqueFd fd_;
};

// A lock on a whole file. It belongs to the open file and not to the process, and a query does not
// disturb the holder.
struct flock Whole(short kind) {
  struct flock lock {};
  lock.l_type = kind;
  lock.l_whence = SEEK_SET;
  return lock;
}

int ReadPid(int fd) {
  std::array<char, 32> text{};
  const ssize_t size = pread(fd, text.data(), text.size(), 0);
  int pid = 0;
  std::from_chars(text.data(), text.data() + std::max<ssize_t>(size, 0), pid);
  return std::max(pid, 0);
}

// Only the lock counts: on a full disk the file may stay empty.
void WritePid(int fd) {
  const std::string pid = std::to_string(getpid()) + "\n";
  if (ftruncate(fd, 0) != 0) return;
  [[maybe_unused]] const ssize_t written = pwrite(fd, pid.data(), pid.size(), 0);
}

}  // namespace

Result<Disk::Info> PosixDisk::Look(const std::string& path) {
  struct stat status {};
  if (lstat(path.c_str(), &status) != 0) {
    if (errno == ENOENT || errno == ENOTDIR) return Info{};
    return SystemError("can't look at " + path);
  }
  Info info;
  info.mode = status.st_mode & 07777U;
  if (S_ISREG(status.st_mode)) {
    info.kind = Kind::kFile;
    info.size_bytes = static_cast<std::uint64_t>(status.st_size);
  } else if (S_ISDIR(status.st_mode)) {
    info.kind = Kind::kFolder;
  } else {
    info.kind = S_ISLNK(status.st_mode) ? Kind::kLink : Kind::kOther;
  }
  return info;
}

Result<std::vector<std::string>> PosixDisk::List(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> names;
  for (const auto& entry : EntriesOf(folder, error)) names.push_back(entry.filename());
  if (error) return SystemError("can't list " + folder, error.value());
  return names;
}

Result<std::string> PosixDisk::ReadLink(const std::string& path) {
  std::array<char, PATH_MAX> target{};
  const ssize_t size = readlink(path.c_str(), target.data(), target.size());
  if (size < 0) return SystemError("can't read the link " + path);
  return std::string(target.data(), static_cast<std::size_t>(size));
}

// Without O_NONBLOCK opening a pipe would block.
Result<std::unique_ptr<Disk::Reader>> PosixDisk::Open(const std::string& path) {
  UniqueFd fd(open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (!fd.valid() || fstat(fd.get(), &status) != 0) return SystemError("can't open " + path);
  if (!S_ISREG(status.st_mode)) return FaultError(Fault::kBadPath, path + " is not a plain file");
  posix_fadvise(fd.get(), 0, 0, POSIX_FADV_SEQUENTIAL);
  return std::unique_ptr<Reader>(std::make_unique<PosixReader>(path, std::move(fd)));
}

Result<std::uint64_t> PosixDisk::FreeBytes(const std::string& folder) {
  struct statvfs status {};
  if (statvfs(folder.c_str(), &status) != 0) return SystemError("can't look at " + folder);
  return static_cast<std::uint64_t>(status.f_bavail) * status.f_frsize;
}

Result<std::unique_ptr<Disk::Writer>> PosixDisk::Create(const std::string& path, unsigned mode) {
  UniqueFd fd(open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, mode));
  if (!fd.valid() || fchmod(fd.get(), mode) != 0) return DiskError("can't write " + path);
  return std::unique_ptr<Writer>(std::make_unique<PosixWriter>(path, std::move(fd)));
}

Result<> PosixDisk::Sync(const std::string& path) {
  const UniqueFd fd(open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  if (!fd.valid() || fsync(fd.get()) != 0) return DiskError("can't sync " + path);
  posix_fadvise(fd.get(), 0, 0, POSIX_FADV_DONTNEED);
  return Ok();
}

Result<> PosixDisk::MakeFolder(const std::string& path) {
  if (mkdir(path.c_str(), 0755) == 0 || errno == EEXIST) return Ok();
  return DiskError("can't make the folder " + path);
}

Result<> PosixDisk::MakeLink(const std::string& target, const std::string& path) {
  if (symlink(target.c_str(), path.c_str()) == 0) return Ok();
  return DiskError("can't make the link " + path);
}

Result<> PosixDisk::Rename(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) == 0) return Ok();
  return DiskError("can't rename " + from + " to " + to);
}

Result<> PosixDisk::Remove(const std::string& path) {
  if (std::remove(path.c_str()) == 0 || errno == ENOENT) return Ok();
  return SystemError("can't remove " + path);
}

Result<std::unique_ptr<Disk::Lock>> PosixDisk::Take(const std::string& path, bool wait) {
  UniqueFd fd(open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0644));
  if (!fd.valid()) return DiskError("can't open " + path);
  struct flock whole = Whole(F_WRLCK);
  int taken = fcntl(fd.get(), F_OFD_SETLK, &whole);
  for (int tries = wait ? kTries : 0; taken != 0 && errno == EAGAIN && tries > 0; --tries) {
    poll(nullptr, 0, kTryEveryMs);
    taken = fcntl(fd.get(), F_OFD_SETLK, &whole);
  }
  if (taken != 0 && errno == EAGAIN) {
    return Error{kCodeTargetBusy,
                 path + " is held by process " + std::to_string(ReadPid(fd.get()))};
  }
  if (taken != 0) return SystemError("can't lock " + path);
  WritePid(fd.get());
  return std::unique_ptr<Lock>(std::make_unique<PosixLock>(std::move(fd)));
}

int HolderOf(const std::string& path) {
  const UniqueFd fd(open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  struct flock whole = Whole(F_RDLCK);
  if (!fd.valid() || fcntl(fd.get(), F_OFD_GETLK, &whole) != 0) return 0;
  return whole.l_type == F_UNLCK ? 0 : ReadPid(fd.get());
}

Result<std::unique_ptr<Disk::Lock>> ResumeLock(const std::string& path, int fd) {
  UniqueFd kept(fd);
  struct stat held {};
  struct stat named {};
  const bool same = fstat(fd, &held) == 0 && lstat(path.c_str(), &named) == 0 &&
                    held.st_dev == named.st_dev && held.st_ino == named.st_ino;
  struct flock whole = Whole(F_WRLCK);
  if (!same || fcntl(fd, F_OFD_SETLK, &whole) != 0) {
    return Error{kCodeStateInvalid, path + " is not held by descriptor " + std::to_string(fd)};
  }
  fcntl(fd, F_SETFD, FD_CLOEXEC);
  return std::unique_ptr<Disk::Lock>(std::make_unique<PosixLock>(std::move(kept)));
}

void WriteHolder(const std::string& path) {
  const UniqueFd fd(open(path.c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC));
  if (fd.valid()) WritePid(fd.get());
}

}  // namespace musher::ota
