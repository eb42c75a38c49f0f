#pragma once
// Where the marks of an axis are.

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

// The first of `distances`, which grow, with which `range` has at most `most` marks; the last one
// where none has.
inline double MarkEvery(double range, double most, std::initializer_list<double> distances) {
  for (const double distance : distances) {
    if (range / distance <= most) return distance;
  }
  return *(distances.end() - 1);
}

}  // namespace musher::world
