#pragma once
// The ring of a recorder: it writes segments of some seconds, deletes those that are older than the
// ring, and after trouble keeps the time around it as one file. Decides; does no IO. Pure: time is
// an argument.
//
//   trouble ──▶ the segments of the last `length` are held ──after `after`──▶ kept as one file
//               (more trouble meanwhile extends the same file)
//
// Counts in steady time: a wall clock that is set changes no length. The wall clock only names
// files.

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "musher/base/time.hpp"

namespace musher::view {

struct RingOptions {
  Duration length = std::chrono::minutes(5);
  Duration after = std::chrono::seconds(30);
  Duration segment = std::chrono::seconds(10);
  std::size_t max_kept = 20;  // files; then the oldest one is deleted
};

// What the recorder is to do, in this order.
struct BeginSegment {
  std::uint64_t number;
  friend bool operator==(const BeginSegment&, const BeginSegment&) = default;
};
struct DeleteSegment {
  std::uint64_t number;
  friend bool operator==(const DeleteSegment&, const DeleteSegment&) = default;
};
struct KeepSegments {
  std::vector<std::uint64_t> numbers;  // oldest first
  std::string reason;
  std::int64_t trouble_ns;  // when it happened, since 1970
  friend bool operator==(const KeepSegments&, const KeepSegments&) = default;
};
using RingAction = std::variant<BeginSegment, DeleteSegment, KeepSegments>;

class Ring {
 public:
  // The first segment gets the number `first`.
  explicit Ring(RingOptions options, std::uint64_t first = 1) : options_(options), next_(first) {}

  // The time is now: call it at the beginning and at least every second.
  std::vector<RingAction> At(Time now);
  // Something went wrong; `wall_ns` since 1970.
  void OnTrouble(const std::string& reason, Time now, std::int64_t wall_ns);
  // The recorder ends: trouble that waits for what comes after it is kept now.
  std::vector<RingAction> End(Time now);

 private:
  struct Segment {
    std::uint64_t number;
    Time begin;
    std::optional<Time> end;  // of the current one: none
  };
  struct Trouble {
    std::string reason;
    std::int64_t wall_ns;
    Time first;
    Time keep_until;
  };

  KeepSegments Keep() const;
  Time OldestNeeded(Time now) const;

  RingOptions options_;
  std::uint64_t next_;
  std::deque<Segment> segments_;
  std::optional<Trouble> trouble_;
};

// "2026-03-01T12-00-05Z_emergency-stop.mcap", sorted by time, safe as a file's name.
std::string KeptName(std::int64_t trouble_ns, const std::string& reason);
// Whether a file has such a name: others are not the recorder's.
bool IsKeptName(std::string_view name);

// "00000012.mcap", and its number; 0: the file is no segment.
std::string SegmentName(std::uint64_t number);
std::uint64_t SegmentNumber(std::string_view name);

// The kept files to delete so that at most `max` are left; `names` in any order.
std::vector<std::string> OldestBeyond(std::vector<std::string> names, std::size_t max);

}  // namespace musher::view
