#pragma once
// Files made of files: the segments of a ring as one, and what can be read of a damaged one.

#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/view/mcap/writer.hpp"

namespace musher::view {

// Writes the messages of these files, oldest first, into a new file; a sample that a later file
// repeats from an earlier one is written once. A file that cannot be read is left out; fails if
// none can.
Result<> MergeSegments(const std::vector<std::string>& segments, const std::string& out,
                       mcap::Compression compression);

// Writes all that can be read of any MCAP file into a new one; returns a sentence about it.
Result<std::string> Recover(const std::string& damaged, const std::string& out,
                            mcap::Compression compression);

}  // namespace musher::view
