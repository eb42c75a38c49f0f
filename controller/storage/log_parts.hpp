#pragma once
// The compressed parts of a log file on disk, <file>.<n>.gz (log_files.hpp).
//
// Threads: any; reads the disk.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/controller/storage/log_rotation.hpp"

namespace musher {

std::string LogPartPath(const std::string& path, std::uint64_t number);
// Oldest first.
std::vector<LogPart> LogPartsOf(const std::string& path);

}  // namespace musher
