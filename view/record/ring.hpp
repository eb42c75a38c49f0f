#pragma once
// The ring of a recorder: it writes segments of some seconds, deletes those that are older than the
// ring, and after trouble keeps the time around it as one file. Decides; does no IO. Pure: time is
// an argument.
//
//   trouble ──▶ the segments of the last `length` are held ──after `after`──▶ kept as one file
//               (more trouble meanwhile extends the same file)
//
// Times are nanoseconds since 1970, as in the files.

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
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
  std::int64_t trouble_ns;  // when it happened
  friend bool operator==(const KeepSegments&, const KeepSegments&) = default;
};
using RingAction = std::variant<BeginSegment, DeleteSegment, KeepSegments>;

class Ring {
 public:
  explicit Ring(RingOptions options) : options_(options) {}

  // The time is now: call it at the beginning and at least every second.
  std::vector<RingAction> At(std::int64_t now_ns);
  // Something went wrong.
  void OnTrouble(const std::string& reason, std::int64_t now_ns);
  // The recorder ends: trouble that waits for what comes after it is kept now.
  std::vector<RingAction> End(std::int64_t now_ns);

 private:
  struct Segment {
    std::uint64_t number;
    std::int64_t begin_ns;
    std::int64_t end_ns;  // of the current one: 0
  };
  struct Trouble {
    std::string reason;
    std::int64_t first_ns;
    std::int64_t keep_until_ns;
  };

  KeepSegments Keep() const;
  std::int64_t OldestNeeded(std::int64_t now_ns) const;

  RingOptions options_;
  std::uint64_t next_ = 1;
  std::deque<Segment> segments_;
  std::optional<Trouble> trouble_;
};

// "2026-03-01T12-00-05Z_emergency-stop.mcap", sorted by time, safe as a file's name.
std::string KeptName(std::int64_t trouble_ns, const std::string& reason);

// The kept files to delete so that at most `max` are left; `names` in any order.
std::vector<std::string> OldestBeyond(std::vector<std::string> names, std::size_t max);

}  // namespace musher::view
