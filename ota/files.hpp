#pragma once
// Compares the files of a version with its manifest, or copies them.

#include <cstdint>
#include <functional>
#include <string>

#include "musher/ota/disk.hpp"
#include "musher/ota/manifest.hpp"

namespace musher::ota {

// Called repeatedly with the number of bytes just processed; returns false to stop.
using OnBytes = std::function<bool(std::uint64_t bytes)>;

// Digest and size of a file.
struct Digest {
  std::string sha256;
  std::uint64_t size_bytes = 0;
};
Result<Digest> DigestOf(Disk& disk, const std::string& path, const OnBytes& on_bytes);

// Whether `folder` has every file of the manifest unaltered: Fault::kMissing, kAltered. Ignores
// other files: a module may leave a file in its slot.
Result<> CheckFiles(Disk& disk, const std::string& folder, const Manifest& manifest,
                    const OnBytes& on_bytes);

// Whether it has no other files: Fault::kExtra, and kBadPath for links and other kinds.
Result<> CheckNothingElse(Disk& disk, const std::string& folder, const Manifest& manifest);

// The folder of a version's programs, first in PATH.
inline constexpr const char* kProgramFolder = "bin";

// Whether the program folder in `folder` has no executable that is not in the manifest: it would
// run instead of any other program of its name. Fault::kExtra for an executable file and for a
// link; ignores other files that a module leaves there.
Result<> CheckPrograms(Disk& disk, const std::string& folder, const Manifest& manifest);

// Copies the files from one folder into another, which must be empty. Computes the digest from the
// written bytes, so that a change of the source meanwhile is detected.
Result<> CopyFiles(Disk& disk, const std::string& from, const std::string& to,
                   const Manifest& manifest, const OnBytes& on_bytes);

// Syncs everything in `folder` to disk, with its name.
Result<> SyncTree(Disk& disk, const std::string& folder);

}  // namespace musher::ota
