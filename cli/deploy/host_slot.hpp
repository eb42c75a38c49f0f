#pragma once
// What `musher deploy` does on each host, in the upgrade root there (ota/root.hpp). The version
// that ROOT/current leads to runs; a new one is written beside it.
//
//   ROOT.incoming/   bundle/ and ota.pub, as they were sent
//   ROOT.new/        a new root with its first version, until it is switched to
//
// No controller runs on such a host, which could try a version: what is switched to is confirmed.
//
// Threads: one.

#include <string>

#include "musher/ota/install.hpp"

namespace musher::cli {

std::string IncomingFolder(const std::string& root);

// Writes the version that was sent into the slot that does not run, or into a new root. Refuses
// what an upgrade refuses: a version that is not newer, an altered file, too little space.
Result<> StageSlot(ota::Disk& disk, const std::string& root, const std::string& version,
                   ota::InstallOptions options);

// Makes the staged version the one that runs.
Result<> SwitchSlot(ota::Disk& disk, const std::string& root, const std::string& version);

// Makes the version before it the one that runs again; nothing happens if `version` is not the one
// that runs. A root that it was the first of is put aside.
Result<> UndoSlot(ota::Disk& disk, const std::string& root, const std::string& version);

}  // namespace musher::cli
