#pragma once
// The files of a version, compared with its manifest or copied by it.

#include <cstdint>
#include <functional>
#include <string>

#include "musher/controller/ota/disk.hpp"
#include "musher/controller/ota/manifest.hpp"

namespace musher::ota {

// Told now and then how many bytes are done; false: stop.
using OnBytes = std::function<bool(std::uint64_t bytes)>;

// The digest of a file, and its size.
struct Digest {
  std::string sha256;
  std::uint64_t size_bytes = 0;
};
Result<Digest> DigestOf(Disk& disk, const std::string& path, const OnBytes& on_bytes);

// Whether `folder` has every file of the manifest, whole: Fault::kMissing, kAltered. What it has
// beside them is of no interest: a module may leave a file in its slot.
Result<> CheckFiles(Disk& disk, const std::string& folder, const Manifest& manifest,
                    const OnBytes& on_bytes);

// Whether it has nothing beside them: Fault::kExtra, and kBadPath for links and the like.
Result<> CheckNothingElse(Disk& disk, const std::string& folder, const Manifest& manifest);

// The folder of a version that comes first on PATH.
inline constexpr const char* kProgramFolder = "bin";

// Whether the folder of programs in `folder` has nothing that could be run and is not of the
// manifest: it would be found before all other programs of its name. Fault::kExtra for a file that
// is executable and for a link; what a module leaves there beside them is of no interest.
Result<> CheckPrograms(Disk& disk, const std::string& folder, const Manifest& manifest);

// Copies the files from one folder into another, which is empty. The digest is taken of the bytes
// that are written, so that it does not matter who changes the source meanwhile.
Result<> CopyFiles(Disk& disk, const std::string& from, const std::string& to,
                   const Manifest& manifest, const OnBytes& on_bytes);

// Everything in `folder` is on disk after this, with its name.
Result<> SyncTree(Disk& disk, const std::string& folder);

}  // namespace musher::ota
