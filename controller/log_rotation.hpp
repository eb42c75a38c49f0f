#pragma once
// What is to be done about the log files of a robot, from their sizes alone. log_files.hpp does it.
//
// A log is a live file, which a process appends to, and older parts of it, compressed and numbered.
// Of its bound the live file has a fifth, and as much again for what comes before the next look;
// the compressed parts have the rest.

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
  std::int64_t save = 0;              // go into a new part first,
  std::int64_t drop = 0;              // and so many after them are lost
  std::vector<std::uint64_t> remove;  // parts, by number

  friend bool operator==(const LogActions&, const LogActions&) = default;
};

inline constexpr std::size_t kMostLogParts = 20;

// The bound of a log: its own, or less where all of them together would exceed theirs.
std::int64_t LogBound(std::int64_t max_bytes, std::int64_t max_total_bytes, std::size_t logs);

LogActions RotationOf(const LogSizes& log);

// What all logs have too much together: the oldest parts first, as pairs of the log's index and the
// part's number.
std::vector<std::pair<std::size_t, std::uint64_t>> PartsBeyond(std::int64_t max_total_bytes,
                                                               const std::vector<LogSizes>& logs);

}  // namespace musher
