#pragma once
// Reads a log file (log_files.hpp) that a process appends to and a controller may rotate meanwhile.
//
// Threads: any, one at a time; reads the disk.

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/controller/storage/log_times.hpp"

namespace musher {

struct WrittenLine {
  std::string text;             // without newline
  std::int64_t written_ns = 0;  // by then (log_times.hpp), since 1970; 0: not known

  friend bool operator==(const WrittenLine&, const WrittenLine&) = default;
};

// Reads a log from its end towards its begin: first the live file, then its compressed parts.
class LogReader {
 public:
  // Fails if the live file cannot be read.
  static Result<LogReader> Open(const std::string& path);

  // The next older lines, oldest first; empty: there are no more.
  std::vector<WrittenLine> Before();

  std::int64_t end() const { return end_; }  // of the live file: the bytes that were read
  std::size_t parts() const { return parts_.size(); }
  const std::string& damage() const { return damage_; }  // a part that cannot be read

 private:
  LogReader(std::string path, UniqueFd file, std::int64_t end);

  struct Piece {
    std::uint64_t part = kLiveLog;
    std::int64_t begin = 0;  // where it begins in its part
    std::string text;
  };

  std::optional<Piece> PieceBefore();  // what was read; nullopt: there is none
  std::vector<WrittenLine> LinesOf(Piece piece);

  std::string path_;
  UniqueFd file_;
  std::int64_t end_ = 0;
  std::int64_t at_ = 0;  // the live file is read from here on
  std::vector<std::uint64_t> parts_;
  std::size_t left_ = 0;  // parts that were not read
  WrittenLine begun_;     // the first line that was read; the piece before it may complete it
  bool any_ = false;      // a piece was read
  LogTimes times_;
  std::string damage_;
};

// What is appended from a position on. The file may be removed and made again, copied and
// truncated, or lose its front: the tail finds its place by the text before it.
class LogTail {
 public:
  LogTail(std::string path, std::int64_t at);

  // The lines that were completed since the last call, without newlines.
  std::vector<std::string> Read();

 private:
  void Reopen();
  void FindPlace(std::int64_t size);

  std::string path_;
  UniqueFd file_;
  std::int64_t at_;
  std::string before_;   // the text that ends at `at_`, at most kAnchor bytes
  std::string pending_;  // a line without its end
};

}  // namespace musher
