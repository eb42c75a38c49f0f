#pragma once
// Whether a person is too close. Pure: time is the pictures' own.
//
//            seen nearer than near_m
//   clear ────────────────────────────▶ too close ◀──┐ not seen: it stays so for `hold`
//     ▲                                    │  └──────┘
//     └────────────────────────────────────┘
//        each person who was too near: seen beyond clear_m, or unseen for `hold`
//
// A face that is very near fills the picture or leaves it, and then no detector finds it. So a
// face that is not seen any more proves nothing: only pictures in which it could have been seen
// again, for `hold`, or a sighting farther away. Time without pictures does not count. For the
// same reason the result is unknown at the beginning, until a face is seen or `hold` has passed: a
// person who is too near may have been there before.

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "musher/base/time.hpp"

namespace musher::vision {

struct ClosenessRules {
  double near_m = 0.8;
  double clear_m = 1.0;
  Duration hold = Milliseconds(10000);
  Duration longest_gap = Milliseconds(2000);  // between two pictures; a longer gap counts as this

  friend bool operator==(const ClosenessRules&, const ClosenessRules&) = default;
};

class Closeness {
 public:
  explicit Closeness(const ClosenessRules& rules) : rules_(rules) {}

  struct Sighting {
    int id = 0;  // never of two people
    double distance_m = 0;
  };
  // All faces that are seen in a picture. Returns too_close().
  bool OnPicture(std::int64_t stamp_ns, const std::vector<Sighting>& seen);

  bool too_close() const { return !near_.empty(); }
  // Whether too_close() is based on pictures.
  bool known() const { return known_; }
  // The persons who count as too near until seen farther away.
  std::set<int> TooNear() const;

 private:
  ClosenessRules rules_;
  std::map<int, Duration> near_;  // id → time unseen, of those too near when last seen
  std::optional<std::int64_t> last_ns_;
  Duration watched_{};  // while no face was seen yet
  bool known_ = false;
};

}  // namespace musher::vision
