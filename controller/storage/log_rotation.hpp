#pragma once
// Decides the rotation of a robot's log files from their sizes. log_files.hpp carries it out.
//
// A log is a live file, which a process appends to, and older parts, compressed and numbered. Of
// its limit the live file gets a fifth, and another fifth for output until the next check; the
// compressed parts get the rest.

#include <cstdint>
#include <utility>
#include <vector>

namespace musher {

// A compressed part of a log.
struct LogPart {
  std::uint64_t number = 0;  // grows with time
  std::int64_t bytes = 0;
  std::int64_t written_ns = 0;  // since 1970

  friend bool operator==(const LogPart&, const LogPart&) = default;
};

struct LogSizes {
  std::int64_t max_bytes = 0;   // its bound, all parts together
  std::int64_t live_bytes = 0;  // of the file that is appended to
  std::vector<LogPart> parts;   // oldest first
  bool no_room = false;         // the last attempt to write a part failed

  std::int64_t total() const;
};

// In bytes from the front of the live file.
struct LogActions {
  std::int64_t save = 0;              // written to a new part,
  std::int64_t drop = 0;              // bytes after them that are dropped
  std::vector<std::uint64_t> remove;  // parts, by number

  friend bool operator==(const LogActions&, const LogActions&) = default;
};

inline constexpr std::size_t kMostLogParts = 20;

// The limit of a log: its own, or less if all together would exceed the total limit.
std::int64_t LogBound(std::int64_t max_bytes, std::int64_t max_total_bytes, std::size_t logs);

LogActions RotationOf(const LogSizes& log);

// The parts that exceed the total limit, oldest first, as pairs of the log's index and the part's
// number.
std::vector<std::pair<std::size_t, std::uint64_t>> PartsBeyond(std::int64_t max_total_bytes,
                                                               const std::vector<LogSizes>& logs);

}  // namespace musher
