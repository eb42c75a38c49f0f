#pragma once
// When the bytes of a log file were written, for lines that have no time of their own.
//
// A process writes into its log itself (log_files.hpp), so its lines cannot be stamped on the way.
// Instead the controller marks in <file>.times how long the log was at which time, when it has
// grown, at most ten times a second: a line has the time of the first mark after its end. What
// was written while no controller ran has no time.
//
// Threads: any, one at a time; reads and writes the disk.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "musher/base/result.hpp"

namespace musher {

inline constexpr std::uint64_t kLiveLog = 0;  // the file itself; its compressed parts begin at 1

struct LogMark {
  std::uint64_t part = kLiveLog;
  std::int64_t end = 0;      // in bytes: up to here,
  std::int64_t wall_ns = 0;  // it was written by then, since 1970; 0: not known when

  friend bool operator==(const LogMark&, const LogMark&) = default;
};

// The marks after the first `save` bytes of the live file became part `number`, and the `drop`
// bytes behind them were dropped. Pure.
std::vector<LogMark> MarksAfterCut(const std::vector<LogMark>& marks, std::int64_t save,
                                   std::int64_t drop, std::uint64_t number);

// The newest `most` marks. What the others covered is not known any more. Pure.
std::vector<LogMark> NewestMarks(std::vector<LogMark> marks, std::size_t most);

// Reads the marks of a log; damaged lines are skipped.
class LogTimes {
 public:
  LogTimes() = default;
  // `live_bytes`: of the live file. Marks beyond it were made for another content.
  LogTimes(const std::string& log, std::int64_t live_bytes);

  // When the bytes before `end` were written, since 1970; 0: not known.
  std::int64_t At(std::uint64_t part, std::int64_t end) const;

 private:
  std::map<std::uint64_t, std::vector<LogMark>> parts_;  // by their ends
};

// Writes the marks of a log.
class LogMarker {
 public:
  explicit LogMarker(const std::string& log);

  // The live file has `bytes` now. The first call marks what was written before as not known.
  Result<> Mark(std::int64_t bytes, std::int64_t wall_ns);
  // As MarksAfterCut(); `parts`: the parts that are left, with the new one.
  Result<> Cut(std::int64_t save, std::int64_t drop, std::uint64_t number,
               const std::vector<std::uint64_t>& parts);
  // The live file was removed and made again.
  Result<> Begin();

 private:
  Result<> Rewrite();
  Result<> Append(const LogMark& mark);

  std::string path_;
  std::vector<LogMark> marks_;
  std::int64_t marked_ = 0;  // bytes of the live file
  bool any_ = false;         // Mark() was called
  bool damaged_ = false;     // the file may end in a part of a line
};

}  // namespace musher
