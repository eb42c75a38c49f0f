#pragma once
// All that upgrades do with files, so small that a test can stop it, fill it or cut its power after
// any of these calls.
//
// Nothing is on disk before Sync() says so: the content of a file after Sync(file), its name after
// Sync(folder). A rename is whole or has not happened.
//
// Threads: one.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/result.hpp"

namespace musher::ota {

class Disk {
 public:
  enum class Kind { kNothing, kFile, kFolder, kLink, kOther };
  struct Info {
    Kind kind = Kind::kNothing;
    std::uint64_t size_bytes = 0;  // of a file
    unsigned mode = 0;             // its permissions
  };
  class Reader {
   public:
    virtual ~Reader() = default;
    // The next bytes, at most `most`; "" at the end.
    virtual Result<std::string_view> Read(std::size_t most) = 0;
  };
  class Writer {
   public:
    virtual ~Writer() = default;
    virtual Result<> Write(std::string_view bytes) = 0;
  };
  // Held until it is dropped, or its process ends in whatever way.
  class Lock {
   public:
    virtual ~Lock() = default;
  };

  virtual ~Disk() = default;

  // Of the thing itself, not of what a link leads to. What is not there is no Error.
  virtual Result<Info> Look(const std::string& path) = 0;
  virtual Result<std::vector<std::string>> List(const std::string& folder) = 0;
  virtual Result<std::string> ReadLink(const std::string& path) = 0;
  // A plain file only: a link, a pipe or a device is an Error.
  virtual Result<std::unique_ptr<Reader>> Open(const std::string& path) = 0;
  virtual Result<std::uint64_t> FreeBytes(const std::string& folder) = 0;

  // A file with these permissions, empty; one that is there is emptied.
  virtual Result<std::unique_ptr<Writer>> Create(const std::string& path, unsigned mode) = 0;
  virtual Result<> Sync(const std::string& path) = 0;
  virtual Result<> MakeFolder(const std::string& path) = 0;
  virtual Result<> MakeLink(const std::string& target, const std::string& path) = 0;
  virtual Result<> Rename(const std::string& from, const std::string& to) = 0;
  virtual Result<> Remove(const std::string& path) = 0;  // a file, a link, an empty folder

  // Fails with kCodeTargetBusy when somebody else has it; with `wait` only when that one keeps it
  // for longer than anybody here does, 10 s.
  virtual Result<std::unique_ptr<Lock>> Take(const std::string& path, bool wait) = 0;
};

// The folder that `path` is in.
std::string FolderOf(const std::string& path);

// The whole of a file; Fault::kMissing when there is none, kCodeFailed when it is larger than
// `most_bytes`.
Result<std::string> ReadAll(Disk& disk, const std::string& path, std::size_t most_bytes);

// A file with this content, not yet synced.
Result<> WriteAll(Disk& disk, const std::string& path, std::string_view text, unsigned mode);

// After a power cut there is the old content or the new one, never half of it.
Result<> Replace(Disk& disk, const std::string& path, std::string_view text, unsigned mode);

// A folder with all that is in it; links are removed, not followed. What is not there is no Error.
Result<> RemoveAll(Disk& disk, const std::string& path);

// All files below `folder` as paths relative to it, sorted. Anything but files and folders is
// Fault::kBadPath.
Result<std::vector<std::string>> FilesBelow(Disk& disk, const std::string& folder);

}  // namespace musher::ota
