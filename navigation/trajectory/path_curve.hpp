#pragma once
// A path as a curve without kinks: straight lines between its poses, and a parabola around each
// corner. x, y, z and yaw together are one curve, so that a turn on the spot is a line as well.
// At a corner sharper than 120 degrees, for example a reversal, the body has to stop.
//
// The curve runs over a parameter u: metres on lines without a turn. Plain value; any thread.

#include <array>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/navigation/pose.hpp"

namespace musher::navigation {

inline constexpr double kLongestPathM = 10'000;  // turns count 1.5 m a radian

using Axes = std::array<double, 4>;  // x, y, z in m, yaw in rad without jumps

// The curve from u = begin on: at + by * s + half * bend * s², with s = u - begin.
struct CurvePiece {
  double begin = 0;
  double length = 0;
  Axes at{};
  Axes by{};
  Axes bend{};
  bool stop_at_end = false;

  Axes PlaceAt(double s) const;
  Axes SlopeAt(double s) const;
};

// `corner_m`: how far the curve may leave the path at a corner. Fails for a path that is empty, has
// numbers that are not finite or is too long. A path that never moves has no pieces.
Result<std::vector<CurvePiece>> MakeCurve(const Path& path, double corner_m);

}  // namespace musher::navigation
