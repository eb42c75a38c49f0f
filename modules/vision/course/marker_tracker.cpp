#include "musher/modules/vision/course/marker_tracker.hpp"

#include "musher/base/check.hpp"

namespace musher::vision {

MarkerTracker::MarkerTracker(int sightings, int misses) : sightings_(sightings), misses_(misses) {
  MUSHER_CHECK(sightings >= 1 && misses >= 1, sightings, misses);
}

MarkerTracker::Phase MarkerTracker::OnPicture(bool seen, bool passes) {
  if (seen) passes_ = passes;
  const bool tracking = phase_ == Phase::kTracking;
  if (seen == tracking) {
    in_row_ = 0;
    return phase_;
  }
  ++in_row_;
  if (in_row_ >= (tracking ? misses_ : sightings_)) {
    in_row_ = 0;
    const Phase gone = passes_ ? Phase::kDisappeared : Phase::kHidden;
    phase_ = tracking ? gone : Phase::kTracking;
  }
  return phase_;
}

std::string PhaseText(MarkerTracker::Phase phase) {
  switch (phase) {
    case MarkerTracker::Phase::kSearching:
      return "searching";
    case MarkerTracker::Phase::kTracking:
      return "tracking";
    case MarkerTracker::Phase::kDisappeared:
      return "disappeared";
    case MarkerTracker::Phase::kHidden:
      return "hidden";
  }
  return "";
}

}  // namespace musher::vision
