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

namespace musher {

// Reads a log from its end towards its begin: first the live file, then its compressed parts.
class LogReader {
 public:
  // Fails if the live file cannot be read.
  static Result<LogReader> Open(const std::string& path);

  // The lines before those that were read already, oldest first, without newlines; empty: there are
  // no more.
  std::vector<std::string> Before();

  std::int64_t end() const { return end_; }  // of the live file: the bytes that were read
  std::size_t parts() const { return parts_.size(); }
  const std::string& damage() const { return damage_; }  // a part that cannot be read

 private:
  LogReader(std::string path, UniqueFd file, std::int64_t end);

  std::optional<std::string> Piece();  // the text before what was read; nullopt: there is none
  std::vector<std::string> LinesOf(std::string text);

  std::string path_;
  UniqueFd file_;
  std::int64_t end_ = 0;
  std::int64_t at_ = 0;  // the live file is read from here on
  std::vector<std::uint64_t> parts_;
  std::size_t left_ = 0;  // parts that were not read
  std::string begun_;     // the first line that was read; the piece before it may complete it
  bool any_ = false;      // a piece was read
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
