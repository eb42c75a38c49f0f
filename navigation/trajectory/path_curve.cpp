#include "musher/navigation/trajectory/path_curve.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "musher/navigation/navigation_fault.hpp"

namespace musher::navigation {
namespace {

constexpr double kMetresARadian = 1.5;
constexpr double kSame = 1e-5;            // poses nearer than this are one
constexpr double kStraight = 1e-9;        // a change of direction that is none
constexpr double kSharpestCosine = -0.5;  // of a corner without a stop

double Dot(const Axes& a, const Axes& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + kMetresARadian * kMetresARadian * a[3] * b[3];
}

Axes Sum(const Axes& a, const Axes& b, double factor) {
  Axes sum{};
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = a[i] + factor * b[i];
  return sum;
}

struct Line {
  Axes from{};
  Axes direction{};  // of length 1
  double length = 0;
};

std::vector<Line> LinesOf(const Path& path) {
  std::vector<Line> lines;
  Axes last = {path[0].at.x_m, path[0].at.y_m, path[0].at.z_m, path[0].yaw_rad};
  for (const Pose& pose : path) {
    const double yaw_rad = last[3] + Wrapped(pose.yaw_rad - last[3]);
    const Axes next = {pose.at.x_m, pose.at.y_m, pose.at.z_m, yaw_rad};
    const Axes way = Sum(next, last, -1);
    const double length = std::sqrt(Dot(way, way));
    if (length < kSame) continue;
    lines.push_back({last, Sum({}, way, 1 / length), length});
    last = next;
  }
  return lines;
}

// Half of the parabola around the corner between two lines; 0 where they are one, or at a stop.
double BlendOf(const Line& before, const Line& after, double corner_m) {
  const Axes change = Sum(after.direction, before.direction, -1);
  const double size = std::sqrt(Dot(change, change));
  if (size < kStraight || Dot(before.direction, after.direction) < kSharpestCosine) return 0;
  return std::min({before.length / 2, after.length / 2, 4 * corner_m / size});
}

bool IsStop(const Line& before, const Line& after, double blend) {
  const Axes change = Sum(after.direction, before.direction, -1);
  return blend < kSame / 10 && std::sqrt(Dot(change, change)) >= kStraight;
}

}  // namespace

Axes CurvePiece::PlaceAt(double s) const {
  return Sum(Sum(at, by, s), bend, s * s / 2);
}

Axes CurvePiece::SlopeAt(double s) const {
  return Sum(by, bend, s);
}

Result<std::vector<CurvePiece>> MakeCurve(const Path& path, double corner_m) {
  if (path.empty()) return MakeError(Fault::kInput, "path: it has no pose");
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (!IsFinite(path[i])) {
      return MakeError(
          Fault::kInput,
          fmt::format("path: pose {} of {} has a number that is not finite", i, path.size()));
    }
  }
  const std::vector<Line> lines = LinesOf(path);
  double whole = 0;
  for (const Line& line : lines) whole += line.length;
  if (!(whole <= kLongestPathM)) {
    return MakeError(Fault::kInput, fmt::format("path: its length is {:.0f} m, at most {:.0f} m",
                                                whole, kLongestPathM));
  }
  std::vector<CurvePiece> pieces;
  double at = 0, cut = 0;  // of the present line: what the corner before it has used
  const auto add = [&](const Axes& from, const Axes& by, const Axes& bend, double length) {
    if (length <= 0) return;
    pieces.push_back({at, length, from, by, bend, false});
    at += length;
  };
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Line& line = lines[i];
    const bool last = i + 1 == lines.size();
    const double blend = last ? 0 : BlendOf(line, lines[i + 1], corner_m);
    add(Sum(line.from, line.direction, cut), line.direction, {}, line.length - cut - blend);
    if (last) break;
    if (IsStop(line, lines[i + 1], blend)) {
      if (!pieces.empty()) pieces.back().stop_at_end = true;
      cut = 0;
      continue;
    }
    cut = blend;
    if (blend == 0) continue;
    const Axes change = Sum(lines[i + 1].direction, line.direction, -1);
    add(Sum(line.from, line.direction, line.length - blend), line.direction,
        Sum({}, change, 1 / (2 * blend)), 2 * blend);
  }
  return pieces;
}

}  // namespace musher::navigation
