#include "musher/ota/disk.hpp"

#include <algorithm>

#include "musher/ota/fault.hpp"

namespace musher::ota {
namespace {

constexpr std::size_t kReadChunk = 64 << 10;  // bytes
constexpr int kDeepest = 32;                  // folders within each other

Result<> Walk(Disk& disk, const std::string& folder, const std::string& below, int depth,
              std::vector<std::string>& files) {
  if (depth > kDeepest) {
    return FaultError(Fault::kBadPath,
                      "folders are nested deeper than " + std::to_string(kDeepest) + ": " + below);
  }
  auto names = disk.List(folder + "/" + below);
  if (!names) return names.error();
  for (const std::string& name : names.value()) {
    const std::string path = below + name;
    const auto info = disk.Look(folder + "/" + path);
    if (!info) return info.error();
    if (info.value().kind == Disk::Kind::kFolder) {
      if (auto walked = Walk(disk, folder, path + "/", depth + 1, files); !walked) return walked;
    } else if (info.value().kind == Disk::Kind::kFile) {
      files.push_back(path);
    } else {
      const bool link = info.value().kind == Disk::Kind::kLink;
      return FaultError(Fault::kBadPath,
                        path + (link ? " is a symbolic link" : " is not a plain file") +
                            "; only files and folders can be upgraded");
    }
  }
  return Ok();
}

}  // namespace

std::string FolderOf(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

Result<std::string> ReadAll(Disk& disk, const std::string& path, std::size_t most_bytes) {
  const auto info = disk.Look(path);
  if (!info) return info.error();
  if (info.value().kind == Disk::Kind::kNothing) {
    return FaultError(Fault::kMissing, path + " is missing");
  }
  if (info.value().size_bytes > most_bytes) {
    return Error{kCodeFailed, path + " has " + std::to_string(info.value().size_bytes) +
                                  " bytes, at most " + std::to_string(most_bytes) + " are read"};
  }
  auto reader = disk.Open(path);
  if (!reader) return reader.error();
  std::string text;
  while (text.size() <= most_bytes) {
    const auto bytes = reader.value()->Read(kReadChunk);
    if (!bytes) return bytes.error();
    if (bytes.value().empty()) return text;
    text += bytes.value();
  }
  return Error{kCodeFailed, path + " grows while it is read"};
}

Result<> WriteAll(Disk& disk, const std::string& path, std::string_view text, unsigned mode) {
  auto writer = disk.Create(path, mode);
  if (!writer) return writer.error();
  return writer.value()->Write(text);
}

Result<> Replace(Disk& disk, const std::string& path, std::string_view text, unsigned mode) {
  const std::string next = path + ".new";
  if (auto written = WriteAll(disk, next, text, mode); !written) return written;
  if (auto synced = disk.Sync(next); !synced) return synced;
  if (auto renamed = disk.Rename(next, path); !renamed) return renamed;
  return disk.Sync(FolderOf(path));
}

Result<> RemoveAll(Disk& disk, const std::string& path) {
  const auto info = disk.Look(path);
  if (!info) return info.error();
  if (info.value().kind == Disk::Kind::kNothing) return Ok();
  if (info.value().kind == Disk::Kind::kFolder) {
    const auto names = disk.List(path);
    if (!names) return names.error();
    for (const std::string& name : names.value()) {
      if (auto removed = RemoveAll(disk, path + "/" + name); !removed) return removed;
    }
  }
  return disk.Remove(path);
}

Result<std::vector<std::string>> FilesBelow(Disk& disk, const std::string& folder) {
  std::vector<std::string> files;
  if (auto walked = Walk(disk, folder, "", 0, files); !walked) return walked.error();
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace musher::ota
