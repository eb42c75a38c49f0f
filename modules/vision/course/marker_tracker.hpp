#pragma once
// From the sightings of a marker, picture by picture, to whether it has been passed. Pure.
//
//                seen `sightings` times in a row                  not seen `misses` times in a row
//   searching ──────────────────────────────────▶ tracking ──────────────────────▶ disappeared
//                                                    ▲                                  │
//                                                    └──────────────────────────────────┘
//                                                      seen `sightings` times in a row
//
// So a single false find neither starts a track nor ends in a disappearance.
//
// Threads: one call at a time.

#include <string>

namespace musher::vision {

class MarkerTracker {
 public:
  enum class Phase { kSearching, kTracking, kDisappeared };

  // Both at least 1.
  MarkerTracker(int sightings, int misses);

  // Whether it is seen in the next picture. Returns phase().
  Phase OnPicture(bool seen);

  Phase phase() const { return phase_; }

 private:
  const int sightings_;
  const int misses_;
  Phase phase_ = Phase::kSearching;
  int in_row_ = 0;  // pictures that contradict the phase
};

// "searching", "tracking" or "disappeared".
std::string PhaseText(MarkerTracker::Phase phase);

}  // namespace musher::vision
