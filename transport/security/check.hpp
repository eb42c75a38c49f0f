#pragma once
// Checks the files of an identity before they are used. DDS Security would either refuse wrong
// files with a number, or accept them and then silently match no participant.

#include <string>

#include "musher/base/result.hpp"
#include "musher/transport/security/key_folder.hpp"
#include "musher/transport/security/wall_time.hpp"

namespace musher::transport::keys {

// Which process uses the key. For another one, which may run as a user of its own, root may check a
// key of that user; the process checks it again.
enum class KeyUse { kByThisProcess, kByAnyProcess };

// Until when they are valid. The error names the wrong file, what is wrong, and what to do.
Result<WallTime> Check(const KeyFolder& folder, const std::string& identity,
                       KeyUse use = KeyUse::kByThisProcess);

}  // namespace musher::transport::keys
