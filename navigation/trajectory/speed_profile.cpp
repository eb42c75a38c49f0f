#include "musher/navigation/trajectory/speed_profile.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace musher::navigation {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kSpacing = 0.02;      // of the grid, in u
constexpr double kMostPoints = 400e3;  // of the grid of a long path
constexpr int kHalvings = 48;          // of a search for the highest speed

struct Range {
  double low = -kInfinite;
  double high = kInfinite;

  void Cut(double from, double to) {
    low = std::max(low, from);
    high = std::min(high, to);
  }
};

double SquareInSpace(const Axes& a) {
  return a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
}

double ProductInSpace(const Axes& a, const Axes& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// The a with |slope * a + offset| <= limit in space, which may be none.
void CutBySpace(const Axes& slope, const Axes& offset, double limit, Range& range) {
  const double square = SquareInSpace(slope);
  const double rest = SquareInSpace(offset) - limit * limit;
  if (square < 1e-18) {
    if (rest > 0) range.Cut(1, -1);
    return;
  }
  const double half = ProductInSpace(slope, offset);
  const double root = half * half - square * rest;
  if (root < 0) return range.Cut(1, -1);
  range.Cut((-half - std::sqrt(root)) / square, (-half + std::sqrt(root)) / square);
}

void CutByYaw(double slope, double offset, double limit, Range& range) {
  if (std::abs(slope) < 1e-9) {
    if (std::abs(offset) > limit) range.Cut(1, -1);
    return;
  }
  const double one = (-limit - offset) / slope, other = (limit - offset) / slope;
  range.Cut(std::min(one, other), std::max(one, other));
}

struct Grid {
  std::vector<Interval> intervals;
  std::vector<double> highest_x;  // at the ends of the intervals, one more than these
};

// A limit that a rounding error must not exceed.
MotionLimits Reduced(const MotionLimits& limits) {
  constexpr double kShare = 1 - 1e-7;
  return {limits.speed_m_s * kShare, limits.acceleration_m_s2 * kShare, limits.yaw_rad_s * kShare,
          limits.yaw_rad_s2 * kShare};
}

double SpeedLimit(const Axes& slope, const MotionLimits& limits) {
  const double in_space = SquareInSpace(slope), yaw = slope[3] * slope[3];
  const double by_space =
      in_space > 1e-18 ? limits.speed_m_s * limits.speed_m_s / in_space : kInfinite;
  const double by_yaw = yaw > 1e-18 ? limits.yaw_rad_s * limits.yaw_rad_s / yaw : kInfinite;
  return std::min(by_space, by_yaw);
}

Grid MakeGrid(const std::vector<CurvePiece>& pieces, const MotionLimits& limits) {
  const double whole = pieces.back().begin + pieces.back().length;
  const double spacing = std::max(kSpacing, whole / kMostPoints);
  Grid grid;
  grid.highest_x = {kInfinite};
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const CurvePiece& piece = pieces[i];
    const bool between_stops = piece.stop_at_end || i + 1 == pieces.size();
    const int count =
        std::max(between_stops ? 4 : 2, static_cast<int>(std::ceil(piece.length / spacing)));
    const double step = piece.length / count;
    for (int k = 0; k < count; ++k) {
      grid.intervals.push_back({i, k * step, step, 0, 0, 0});
      const double limit = std::min(SpeedLimit(piece.SlopeAt(k * step), limits),
                                    SpeedLimit(piece.SlopeAt((k + 1) * step), limits));
      grid.highest_x.back() = std::min(grid.highest_x.back(), limit);
      grid.highest_x.push_back(limit);
    }
    if (piece.stop_at_end) grid.highest_x.back() = 0;
  }
  grid.highest_x.back() = 0;
  return grid;
}

// The accelerations of progress that keep all limits in an interval which begins with `x` and ends
// with at most `highest_next_x`.
class Stage {
 public:
  Stage(const CurvePiece& piece, const Interval& interval, const MotionLimits& limits)
      : limits_(limits),
        length_(interval.length),
        slope_(piece.SlopeAt(interval.from)),
        slope_at_end_(piece.SlopeAt(interval.from + interval.length)),
        bend_(piece.bend) {
    // At the end x has grown by 2 * length * a.
    for (std::size_t i = 0; i < bend_.size(); ++i) slope_at_end_[i] += 2 * length_ * bend_[i];
  }

  Range At(double x, double highest_next_x) const {
    Range range;
    range.Cut(-x / (2 * length_), (highest_next_x - x) / (2 * length_));
    Axes offset{};
    for (std::size_t i = 0; i < bend_.size(); ++i) offset[i] = bend_[i] * x;
    for (const Axes* slope : {&slope_, &slope_at_end_}) {
      CutBySpace(*slope, offset, limits_.acceleration_m_s2, range);
      CutByYaw((*slope)[3], offset[3], limits_.yaw_rad_s2, range);
    }
    return range;
  }

  // The highest x at the begin. The permitted pairs of x and a are a convex set with (0, 0), so the
  // permitted x are a range from 0 on.
  double Highest(double at_most, double highest_next_x) const {
    const auto possible = [&](double x) {
      const Range range = At(x, highest_next_x);
      return range.low <= range.high;
    };
    if (std::isfinite(at_most) && possible(at_most)) return at_most;
    double low = 0, high = std::isfinite(at_most) ? at_most : 1e6;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = (low + high) / 2;
      (possible(middle) ? low : high) = middle;
    }
    return low;
  }

 private:
  const MotionLimits& limits_;
  double length_;
  Axes slope_;
  Axes slope_at_end_;
  Axes bend_;
};

}  // namespace

std::vector<Interval> FastestProgress(const std::vector<CurvePiece>& pieces,
                                      const MotionLimits& limits, double start_speed_m_s) {
  if (pieces.empty()) return {};
  const MotionLimits reduced = Reduced(limits);
  Grid grid = MakeGrid(pieces, reduced);
  std::vector<Interval>& intervals = grid.intervals;
  std::vector<double>& highest = grid.highest_x;
  for (std::size_t i = intervals.size(); i-- > 0;) {
    const Stage stage(pieces[intervals[i].piece], intervals[i], reduced);
    highest[i] = stage.Highest(highest[i], highest[i + 1]);
  }
  const double slope_square = SquareInSpace(pieces[0].by);
  double x = slope_square < 1e-18 ? 0 : start_speed_m_s * start_speed_m_s / slope_square;
  x = std::min(x, highest[0]);
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    Interval& interval = intervals[i];
    const Stage stage(pieces[interval.piece], interval, reduced);
    const Range range = stage.At(x, highest[i + 1]);
    const double next_x = std::clamp(x + 2 * interval.length * range.high, 0.0, highest[i + 1]);
    interval.x = x;
    interval.acceleration = (next_x - x) / (2 * interval.length);
    interval.seconds = 2 * interval.length / (std::sqrt(x) + std::sqrt(next_x));
    x = next_x;
  }
  return intervals;
}

}  // namespace musher::navigation
