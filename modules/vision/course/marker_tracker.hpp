#pragma once
// From the sightings of a marker, picture by picture, to whether it has been passed. Pure.
//
//                seen `sightings` times in a row                  not seen `misses` times in a row
//   searching ──────────────────────────────────▶ tracking ──────────────────────▶ disappeared
//                                                    ▲                             or hidden
//                                                    └──────────────────────────────────┘
//                                                      seen `sightings` times in a row
//
// So a single false find neither starts a track nor ends in a disappearance. What was last seen
// near, at the picture's edge, has left it: it was passed. What was last seen far away or in its
// middle is hidden, by a person or by glare, and still ahead.
//
// Threads: one call at a time.

#include <string>

namespace musher::vision {

class MarkerTracker {
 public:
  enum class Phase { kSearching, kTracking, kDisappeared, kHidden };

  // Both at least 1.
  MarkerTracker(int sightings, int misses);

  // Whether it is seen in the next picture, and there as if it was being passed. Returns phase().
  Phase OnPicture(bool seen, bool passes = false);

  Phase phase() const { return phase_; }

 private:
  const int sightings_;
  const int misses_;
  Phase phase_ = Phase::kSearching;
  int in_row_ = 0;       // pictures that contradict the phase
  bool passes_ = false;  // when it was last seen
};

// "searching", "tracking", "disappeared" or "hidden".
std::string PhaseText(MarkerTracker::Phase phase);

}  // namespace musher::vision
