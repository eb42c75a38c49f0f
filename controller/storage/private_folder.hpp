#pragma once
// Threads: any.

#include <filesystem>
#include <string>

#include "musher/base/result.hpp"

namespace musher {

// Makes a folder and its parents, each accessible only to its owner; existing ones stay unchanged.
Result<> MakePrivateFolder(const std::filesystem::path& path);

// Whether a link has this name.
bool IsLink(const std::filesystem::path& path);

// Whether the controller's log may be a link: only the one of the config's `log`, and not in the
// state folder, where another user may have put it before the folder became ours.
bool LogMayBeLink(const std::string& log, const std::string& state_dir);

}  // namespace musher
