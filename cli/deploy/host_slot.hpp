#pragma once
// What `musher deploy` does on each host, in the upgrade root there (ota/root.hpp). The version
// that ROOT/current leads to runs; a new one is written beside it.
//
//   ROOT.incoming/   bundle/ and ota.pub, as they were sent
//   ROOT.new/        a new root with its first version, until it is switched to
//   ROOT.undone/     the same after it was switched back
//
// No controller runs on such a host, which could try a version: what is switched to is confirmed.
//
// Threads: one.

#include <cstdint>
#include <string>

#include "musher/ota/install.hpp"

namespace musher::cli {

std::string IncomingFolder(const std::string& root);

// What the files of a version are, independent of who signed it when: 64 hexadecimal digits.
std::string ContentDigest(const ota::Manifest& manifest);

// Where a root has a version, with all its files.
enum class Place : std::uint8_t {
  kNowhere,
  kStaged,  // to be switched to
  kRuns
};
struct PlacedVersion {
  Place place = Place::kNowhere;
  std::string digest = {};  // ContentDigest(); empty: nowhere
};
// "runs 9f86d0…", "staged 9f86d0…", "nowhere": what `--step look` prints.
std::string FormatPlaced(const PlacedVersion& placed);
PlacedVersion ParsePlaced(const std::string& line);
// Reads the whole version. A root that is missing has none.
Result<PlacedVersion> FindVersion(ota::Disk& disk, const std::string& root,
                                  const std::string& version);

// Writes the version that was sent into the slot that does not run, or into a new root. Refuses
// what an upgrade refuses: a version that is not newer, an altered file, too little space. Refuses
// to write over a slot from which a process still runs.
Result<> StageSlot(ota::Disk& disk, const std::string& root, const std::string& version,
                   ota::InstallOptions options);

// Makes the staged version the one that runs; one that runs already is left, with its link put
// right.
Result<> SwitchSlot(ota::Disk& disk, const std::string& root, const std::string& version);

// Makes the version before `version` run again, where `version` runs. A root with no other version
// is put aside. `version` is not switched to afterwards, unless it is staged again.
Result<> UndoSlot(ota::Disk& disk, const std::string& root, const std::string& version);

}  // namespace musher::cli
