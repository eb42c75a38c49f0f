#pragma once
// A path whose corners are rounded, so that a body need not stop at them. Pure; any thread.

#include "musher/base/result.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::navigation {

struct RoundRules {
  double corner_m = 0.1;  // how far the path may leave a corner, towards its inside
  double step_m = 0.1;    // between two poses, about
};

// Begin and end stay what they are, the other poses look along the path. A corner of more than 120
// degrees, as where the path leads back, stays. Fails with Fault::kInput for a path without poses,
// with numbers that are not finite, or of more than 10 km.
Result<Path> RoundCorners(const Path& path, const RoundRules& rules = {});

}  // namespace musher::navigation
