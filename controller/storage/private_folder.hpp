#pragma once
// Threads: any.

#include <filesystem>

#include "musher/base/result.hpp"

namespace musher {

// Makes a folder and its parents, each accessible only to its owner; existing ones stay unchanged.
Result<> MakePrivateFolder(const std::filesystem::path& path);

}  // namespace musher
