#pragma once
// Judges the files of an identity before they are used. DDS Security would either refuse them with
// a number, or take them and then match nobody, silently.

#include <string>

#include "musher/lifecycle/result.hpp"
#include "musher/transport/keys/key_folder.hpp"
#include "musher/transport/keys/rights.hpp"

namespace musher::transport::keys {

// Until when they are valid. Fails with the file that is wrong, what is wrong with it, and what
// helps.
Result<WallTime> Check(const KeyFolder& folder, const std::string& identity);

}  // namespace musher::transport::keys
