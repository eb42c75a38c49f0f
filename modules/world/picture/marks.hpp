#pragma once
// The positions of an axis's marks.

#include <cmath>
#include <initializer_list>
#include <vector>

namespace musher::world {

// The multiples of `every` from `least` to `most`.
inline std::vector<double> Marks(double least, double most, double every) {
  constexpr double kRounding = 1e-9;
  const long first = std::lround(std::ceil(least / every - kRounding));
  const long last = std::lround(std::floor(most / every + kRounding));
  std::vector<double> marks;
  for (long i = first; i <= last; ++i) marks.push_back(static_cast<double>(i) * every);
  return marks;
}

// The first of `distances`, in ascending order, that divides `range` into at most `most` parts;
// the last one if none does.
inline double MarkEvery(double range, double most, std::initializer_list<double> distances) {
  for (const double distance : distances) {
    if (range / distance <= most) return distance;
  }
  return *(distances.end() - 1);
}

}  // namespace musher::world
