#pragma once
// Pieces of log files for a page. Threads: any; reads the disk.

#include <cstdint>
#include <string>

#include "musher/base/result.hpp"

namespace musher::view {

struct LogPiece {
  std::int64_t from = 0;  // byte of the file; moved to the begin of a line
  std::int64_t to = 0;    // for the next piece
  std::int64_t size = 0;  // of the file
  std::string text;
};

inline constexpr std::int64_t kMostLogBytes = 64 << 10;  // of a piece

// At most kMostLogBytes of the file from a byte on; `from` negative: so many bytes before its end.
// A file that has become shorter (its log was rotated) is read from its begin. Fails with a
// sentence if it cannot be read.
Result<LogPiece> ReadLog(const std::string& path, std::int64_t from);

}  // namespace musher::view
