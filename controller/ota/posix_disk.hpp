#pragma once
// The files of this computer.
//
// Threads: one.

#include "musher/controller/ota/disk.hpp"

namespace musher::ota {

class PosixDisk : public Disk {
 public:
  Result<Info> Look(const std::string& path) override;
  Result<std::vector<std::string>> List(const std::string& folder) override;
  Result<std::string> ReadLink(const std::string& path) override;
  Result<std::unique_ptr<Reader>> Open(const std::string& path) override;
  Result<std::uint64_t> FreeBytes(const std::string& folder) override;
  Result<std::unique_ptr<Writer>> Create(const std::string& path, unsigned mode) override;
  // Afterwards the file is read from the disk and not from memory, as far as the kernel goes along.
  Result<> Sync(const std::string& path) override;
  Result<> MakeFolder(const std::string& path) override;
  Result<> MakeLink(const std::string& target, const std::string& path) override;
  Result<> Rename(const std::string& from, const std::string& to) override;
  Result<> Remove(const std::string& path) override;
  // An advisory lock on a file, which is made and says whose it is: "4711\n".
  Result<std::unique_ptr<Lock>> Take(const std::string& path, bool wait) override;
};

// The process that holds the lock of this file; 0: nobody does.
int HolderOf(const std::string& path);

}  // namespace musher::ota
