#pragma once
// A note beside the journal that it lacks entries, for the case that the controller ends before it
// can write them: <journal>.gap. The block of the file is allocated while the disk has room, and
// the note is written in its place, which a full disk permits (on a file system that does not copy
// on write).
//
// Threads: the journal's writer; ReadGap() any.

#include <cstdint>
#include <optional>
#include <string>

#include "musher/base/result.hpp"

namespace musher {

struct JournalGap {
  std::int64_t since_wall_ns = 0;  // of the first failure to write
  std::string why;

  // "2026-11-26T07:30:01Z: database or disk is full"
  std::string Text() const;

  friend bool operator==(const JournalGap&, const JournalGap&) = default;
};

// The gap that is noted beside the journal `path`; none: there is none, or it cannot be read.
std::optional<JournalGap> ReadGap(const std::string& path);

// Replaces the note, or clears it. Creates the file.
Result<> WriteGap(const std::string& path, const std::optional<JournalGap>& gap);

}  // namespace musher
