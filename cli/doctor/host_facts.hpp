#pragma once
// The parts of the facts that the kernel and the file system know.

#include "musher/cli/doctor/facts.hpp"

namespace musher::cli {

// A number in a file such as /proc/sys/net/core/rmem_max.
std::optional<std::int64_t> ReadNumber(const std::string& file);
ClockFacts ReadClock();
Limits ReadLimits();
CoreFacts ReadCore();
CpuFacts ReadCpu();

// In a child, for at most `timeout`. `newest_file_s`: the last write in it.
FolderFacts ReadFolder(const std::string& path, Duration timeout, std::int64_t& newest_file_s);

}  // namespace musher::cli
