#pragma once
// All file operations of upgrades, in an interface so small that a test can stop, fill or power-cut
// the disk after each call.
//
// Nothing is on disk before Sync() succeeds: the content of a file after Sync(file), its name after
// Sync(folder). A rename is atomic.
//
// Threads: one.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"

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
  // Held until it is dropped, or its process exits in any way.
  class Lock {
   public:
    virtual ~Lock() = default;
    // It stays held while this process executes a program. Returns the descriptor that holds it
    // then; -1: it has none.
    virtual int KeepForExec() { return -1; }
  };

  virtual ~Disk() = default;

  // Kind and size of the path itself; does not follow links. A missing path is not an Error.
  virtual Result<Info> Look(const std::string& path) = 0;
  virtual Result<std::vector<std::string>> List(const std::string& folder) = 0;
  virtual Result<std::string> ReadLink(const std::string& path) = 0;
  // A plain file only: a link, a pipe or a device is an Error.
  virtual Result<std::unique_ptr<Reader>> Open(const std::string& path) = 0;
  virtual Result<std::uint64_t> FreeBytes(const std::string& folder) = 0;

  // An empty file with these permissions; truncates an existing one.
  virtual Result<std::unique_ptr<Writer>> Create(const std::string& path, unsigned mode) = 0;
  virtual Result<> Sync(const std::string& path) = 0;
  virtual Result<> MakeFolder(const std::string& path) = 0;
  virtual Result<> MakeLink(const std::string& target, const std::string& path) = 0;
  virtual Result<> Rename(const std::string& from, const std::string& to) = 0;
  virtual Result<> Remove(const std::string& path) = 0;  // a file, a link, an empty folder

  // Fails with kCodeTargetBusy if another process holds it; with `wait` only after 10 s, longer
  // than any normal holder.
  virtual Result<std::unique_ptr<Lock>> Take(const std::string& path, bool wait) = 0;
};

// The folder that `path` is in.
std::string FolderOf(const std::string& path);

// The content of a file; Fault::kMissing if it does not exist, kCodeFailed if it is larger than
// `most_bytes`.
Result<std::string> ReadAll(Disk& disk, const std::string& path, std::size_t most_bytes);

// A file with this content, not yet synced.
Result<> WriteAll(Disk& disk, const std::string& path, std::string_view text, unsigned mode);

// Replaces a file atomically: after a power cut it has the old content or the new one.
Result<> Replace(Disk& disk, const std::string& path, std::string_view text, unsigned mode);

// Removes a folder with its content; removes links, does not follow them. A missing path is not an
// Error.
Result<> RemoveAll(Disk& disk, const std::string& path);

// All files below `folder` as paths relative to it, sorted. Fault::kBadPath for anything except
// files and folders.
Result<std::vector<std::string>> FilesBelow(Disk& disk, const std::string& folder);

}  // namespace musher::ota
