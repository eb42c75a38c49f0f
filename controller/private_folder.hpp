#pragma once
// Threads: any.

#include <filesystem>

#include "musher/lifecycle/result.hpp"

namespace musher {

// Makes a folder and those above it, each only for its owner; those that exist stay as they are.
Result<> MakePrivateFolder(const std::filesystem::path& path);

}  // namespace musher
