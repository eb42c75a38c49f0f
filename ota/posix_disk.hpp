#pragma once
// The disk of this computer.
//
// Threads: one.

#include "musher/ota/disk.hpp"

namespace musher::ota {

class PosixDisk : public Disk {
 public:
  Result<Info> Look(const std::string& path) override;
  Result<std::vector<std::string>> List(const std::string& folder) override;
  Result<std::string> ReadLink(const std::string& path) override;
  Result<std::unique_ptr<Reader>> Open(const std::string& path) override;
  Result<std::uint64_t> FreeBytes(const std::string& folder) override;
  Result<std::unique_ptr<Writer>> Create(const std::string& path, unsigned mode) override;
  // Also drops the file from the page cache, so that it is then read from the disk if the kernel
  // complies.
  Result<> Sync(const std::string& path) override;
  Result<> MakeFolder(const std::string& path) override;
  Result<> MakeLink(const std::string& target, const std::string& path) override;
  Result<> Rename(const std::string& from, const std::string& to) override;
  Result<> Remove(const std::string& path) override;
  // An advisory lock on a file, which is created and contains the holder's pid: "4711\n".
  Result<std::unique_ptr<Lock>> Take(const std::string& path, bool wait) override;
};

// The lock of this file that this process held when it executed its program again, by the
// descriptor of KeepForExec(); it is closed with the lock, or at once if it does not hold it.
Result<std::unique_ptr<Disk::Lock>> ResumeLock(const std::string& path, int fd);

// The process that holds the lock of this file; 0: none.
int HolderOf(const std::string& path);

// Writes this process's pid into the file of a lock that it holds: for a lock that was taken before
// a fork.
void WriteHolder(const std::string& path);

}  // namespace musher::ota
