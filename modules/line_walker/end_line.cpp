#include "musher/modules/line_walker/end_line.hpp"

#include <algorithm>
#include <cmath>

namespace musher::line_walker {
namespace {

constexpr std::size_t kEndCorners = 24;  // points that hypotheses go through
constexpr double kContinuesM = 0.08;     // a point so near to a curve may continue it
constexpr double kSameLineM = 0.15;      // along the lane; of these the longer one counts

GroundPoint Turned(const GroundPoint& point, double by_rad) {
  const double cosine = std::cos(by_rad);
  const double sine = std::sin(by_rad);
  return {cosine * point.x_m - sine * point.y_m, sine * point.x_m + cosine * point.y_m};
}

// x = at_m + slope * y, in a frame with x along the lane.
struct Across {
  double at_m = 0;
  double slope = 0;

  double Off(const GroundPoint& point) const {
    return std::abs(point.x_m - at_m - slope * point.y_m) / std::sqrt(1 + slope * slope);
  }
};

double SpanOf(const GroundPoints& line) {
  return line.empty() ? 0 : line.back().y_m - line.front().y_m;
}

// Sorted by y: the longest run without a gap.
GroundPoints LongestRun(const GroundPoints& line, double longest_gap_m) {
  GroundPoints longest;
  GroundPoints run;
  for (const GroundPoint& point : line) {
    if (!run.empty() && point.y_m - run.back().y_m > longest_gap_m) run.clear();
    run.push_back(point);
    if (SpanOf(run) > SpanOf(longest)) longest = run;
  }
  return longest;
}

// Least squares.
Across BestThrough(const GroundPoints& points) {
  const auto n = double(points.size());
  double x = 0;
  double y = 0;
  for (const GroundPoint& point : points) {
    x += point.x_m / n;
    y += point.y_m / n;
  }
  double yy = 0;
  double xy = 0;
  for (const GroundPoint& point : points) {
    yy += (point.y_m - y) * (point.y_m - y);
    xy += (point.x_m - x) * (point.y_m - y);
  }
  const double slope = yy > 0 ? xy / yy : 0;
  return {x - slope * y, slope};
}

class EndSearch {
 public:
  // `points`: sorted by y, with x along the lane.
  EndSearch(const GroundPoints& points, const EndRules& rules)
      : points_(points), rules_(rules), steepest_(std::tan(rules.squint_rad)) {}

  void Run() {
    const std::size_t step = std::max<std::size_t>(1, points_.size() / kEndCorners);
    for (std::size_t i = 0; i < points_.size(); i += step) {
      for (std::size_t j = i + step; j < points_.size(); j += step) {
        Consider(points_[i], points_[j]);
      }
    }
  }

  std::optional<Across> line;
  GroundPoint middle;  // of it

 private:
  void Consider(const GroundPoint& a, const GroundPoint& b) {
    const double across_m = b.y_m - a.y_m;
    if (across_m < rules_.least_span_m / 2) return;
    const double slope = (b.x_m - a.x_m) / across_m;
    if (std::abs(slope) > steepest_) return;
    const Across through{a.x_m - slope * a.y_m, slope};
    GroundPoints near;
    for (const GroundPoint& point : points_) {
      if (through.Off(point) <= rules_.tolerance_m) near.push_back(point);
    }
    near = LongestRun(near, rules_.longest_gap_m);
    if (int(near.size()) < rules_.least_points || SpanOf(near) < rules_.least_span_m) return;
    const Across best = BestThrough(near);
    if (std::abs(best.slope) > steepest_) return;
    const double y = (near.front().y_m + near.back().y_m) / 2;
    const GroundPoint found{best.at_m + best.slope * y, y};
    const double away_m = std::hypot(found.x_m, found.y_m);
    if (found.x_m <= 0 || away_m > rules_.within_m) return;
    const double span_m = SpanOf(near);
    const double nearer_m = middle.x_m - found.x_m;
    const bool same = std::abs(nearer_m) < kSameLineM;
    if (line && !(same ? span_m > span_m_ : nearer_m > 0)) return;
    span_m_ = span_m;
    line = best;
    middle = found;
  }

  const GroundPoints& points_;
  const EndRules& rules_;
  const double steepest_;
  double span_m_ = 0;
};

}  // namespace

std::optional<EndLine> FindEndLine(const GroundPoints& all, double lane_heading_rad,
                                   const EndRules& rules) {
  GroundPoints points;
  for (const GroundPoint& point : all) {
    const double away_m = std::hypot(point.x_m, point.y_m);
    if (away_m <= rules.within_m + rules.least_span_m) {  // NaN is not
      points.push_back(Turned(point, -lane_heading_rad));
    }
  }
  std::sort(points.begin(), points.end(),
            [](const GroundPoint& a, const GroundPoint& b) { return a.y_m < b.y_m; });
  EndSearch search(points, rules);
  search.Run();
  if (!search.line) return std::nullopt;
  return EndLine{Turned(search.middle, lane_heading_rad),
                 lane_heading_rad - std::atan(search.line->slope)};
}

std::optional<EndLine> FindSideEnd(const GroundPoints& points, const SideLine& line, Side side,
                                   const MountedCamera& camera, double trunk_height_m,
                                   double lane_width_m, const EndRules& rules) {
  const double end_x = line.far_x_m;
  if (end_x > rules.side_within_m || end_x < -rules.side_within_m) return std::nullopt;
  const std::array<double, 3>& c = line.curve;
  const auto at = [&c](double x) { return c[0] + x * (c[1] + x * c[2]); };
  // The camera has to show what would be there.
  const double beyond_x = end_x + rules.side_gap_m;
  for (const double x : {end_x, beyond_x}) {
    const auto share = ShareOf(camera, trunk_height_m, {x, at(x)});
    if (!share || (*share)[1] < camera.region_top) return std::nullopt;
  }
  for (const GroundPoint& point : points) {
    const bool beyond = point.x_m > end_x && point.x_m < beyond_x;
    if (beyond && std::abs(point.y_m - at(point.x_m)) < kContinuesM) return std::nullopt;
  }
  const double heading = std::atan(c[1] + 2 * c[2] * end_x);
  const double aside = (side == Side::kLeft ? -1 : 1) * lane_width_m / 2;
  return EndLine{{end_x - aside * std::sin(heading), at(end_x) + aside * std::cos(heading)},
                 heading};
}

}  // namespace musher::line_walker
