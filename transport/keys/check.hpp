#pragma once
// Judges the files of an identity before they are used. DDS Security would either refuse them with
// a number, or take them and then match nobody, silently.

#include "musher/transport/keys/key_folder.hpp"

namespace musher::transport::keys {

// Fails with the file that is wrong, what is wrong with it, and what helps.
Result<> Check(const KeyFolder& folder, const std::string& identity);

}  // namespace musher::transport::keys
