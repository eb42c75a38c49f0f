#include "musher/ota/files.hpp"

#include <set>

#include "musher/ota/fault.hpp"
#include "musher/ota/signature.hpp"

namespace musher::ota {
namespace {

constexpr std::size_t kCopyChunk = 256 << 10;  // bytes

Error Interrupted() {
  return {kCodeFailed, "interrupted"};
}

// Reads a file to its end, passes each piece to `take`.
Result<Digest> Stream(Disk& disk, const std::string& path, const OnBytes& on_bytes,
                      const std::function<Result<>(std::string_view)>& take) {
  auto reader = disk.Open(path);
  if (!reader) return reader.error();
  Sha256 sha;
  Digest digest;
  while (true) {
    const auto bytes = reader.value()->Read(kCopyChunk);
    if (!bytes) return bytes.error();
    if (bytes.value().empty()) break;
    sha.Add(bytes.value());
    digest.size_bytes += bytes.value().size();
    if (auto taken = take(bytes.value()); !taken) return taken.error();
    if (on_bytes && !on_bytes(bytes.value().size())) return Interrupted();
  }
  digest.sha256 = sha.Finish();
  return digest;
}

Result<> Compare(const FileEntry& file, const Digest& digest) {
  if (digest.size_bytes != file.size_bytes) {
    return FaultError(Fault::kAltered, file.path + " has " + std::to_string(digest.size_bytes) +
                                           " bytes instead of " + std::to_string(file.size_bytes));
  }
  if (digest.sha256 != file.sha256) {
    return FaultError(Fault::kAltered, file.path + " is not the file that was signed");
  }
  return Ok();
}

Result<> MakeFolders(Disk& disk, const std::string& folder, const std::string& path,
                     std::set<std::string>& made) {
  for (std::size_t slash = path.find('/'); slash != std::string::npos;
       slash = path.find('/', slash + 1)) {
    const std::string below = path.substr(0, slash);
    if (!made.insert(below).second) continue;
    if (auto done = disk.MakeFolder(folder + "/" + below); !done) return done;
  }
  return Ok();
}

}  // namespace

Result<Digest> DigestOf(Disk& disk, const std::string& path, const OnBytes& on_bytes) {
  return Stream(disk, path, on_bytes, [](std::string_view) { return Ok(); });
}

Result<> CheckFiles(Disk& disk, const std::string& folder, const Manifest& manifest,
                    const OnBytes& on_bytes) {
  for (const FileEntry& file : manifest.files) {
    const std::string path = folder + "/" + file.path;
    const auto info = disk.Look(path);
    if (!info) return info.error();
    if (info.value().kind == Disk::Kind::kNothing) {
      return FaultError(Fault::kMissing, file.path + " is missing");
    }
    if (info.value().kind != Disk::Kind::kFile) {
      return FaultError(Fault::kBadPath, file.path + " is not a plain file");
    }
    // Checked before reading: a file of the wrong size need not be read.
    if (info.value().size_bytes != file.size_bytes) {
      return Compare(file, {file.sha256, info.value().size_bytes});
    }
    const auto digest = DigestOf(disk, path, on_bytes);
    if (!digest) return digest.error();
    if (auto same = Compare(file, digest.value()); !same) return same;
  }
  return Ok();
}

Result<> CheckNothingElse(Disk& disk, const std::string& folder, const Manifest& manifest) {
  const auto found = FilesBelow(disk, folder);
  if (!found) return found.error();
  std::set<std::string_view> listed;
  for (const FileEntry& file : manifest.files) listed.insert(file.path);
  for (const std::string& path : found.value()) {
    if (!listed.contains(path)) {
      return FaultError(Fault::kExtra, path + " is not in the manifest");
    }
  }
  return Ok();
}

Result<> CheckPrograms(Disk& disk, const std::string& folder, const Manifest& manifest) {
  constexpr unsigned kExecutable = 0111;
  const std::string programs = folder + "/" + kProgramFolder;
  const auto there = disk.Look(programs);
  if (!there) return there.error();
  if (there.value().kind == Disk::Kind::kNothing) return Ok();
  if (there.value().kind != Disk::Kind::kFolder) {
    return FaultError(Fault::kBadPath, std::string(kProgramFolder) + " is not a folder");
  }
  const auto names = disk.List(programs);
  if (!names) return names.error();
  std::set<std::string_view> listed;
  for (const FileEntry& file : manifest.files) listed.insert(file.path);
  for (const std::string& name : names.value()) {
    const std::string path = std::string(kProgramFolder) + "/" + name;
    const auto info = disk.Look(folder + "/" + path);
    if (!info) return info.error();
    const bool is_file = info.value().kind == Disk::Kind::kFile;
    const bool can_run =
        is_file ? (info.value().mode & kExecutable) != 0 : info.value().kind == Disk::Kind::kLink;
    if (!can_run || listed.contains(path)) continue;
    return FaultError(Fault::kExtra,
                      path +
                          " is not in the signed manifest, and would be run instead of "
                          "any other program of its name; remove it");
  }
  return Ok();
}

Result<> CopyFiles(Disk& disk, const std::string& from, const std::string& to,
                   const Manifest& manifest, const OnBytes& on_bytes) {
  std::set<std::string> made;
  for (const FileEntry& file : manifest.files) {
    if (auto done = MakeFolders(disk, to, file.path, made); !done) return done;
    auto writer = disk.Create(to + "/" + file.path, file.mode);
    if (!writer) return writer.error();
    std::uint64_t left = file.size_bytes;
    const auto digest =
        Stream(disk, from + "/" + file.path, on_bytes, [&](std::string_view bytes) -> Result<> {
          if (bytes.size() > left) {
            return FaultError(Fault::kAltered, file.path + " grows while it is copied");
          }
          left -= bytes.size();
          return writer.value()->Write(bytes);
        });
    if (!digest) return digest.error();
    if (auto same = Compare(file, digest.value()); !same) return same;
  }
  return Ok();
}

Result<> SyncTree(Disk& disk, const std::string& folder) {
  const auto names = disk.List(folder);
  if (!names) return names.error();
  for (const std::string& name : names.value()) {
    const std::string path = folder + "/" + name;
    const auto info = disk.Look(path);
    if (!info) return info.error();
    const bool is_folder = info.value().kind == Disk::Kind::kFolder;
    if (auto synced = is_folder ? SyncTree(disk, path) : disk.Sync(path); !synced) return synced;
  }
  return disk.Sync(folder);
}

}  // namespace musher::ota
