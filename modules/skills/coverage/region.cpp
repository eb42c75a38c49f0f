#include "musher/modules/skills/coverage/region.hpp"
#include "musher/base/words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace musher::coverage {
namespace {

constexpr double kTouchingM = 1e-6;
constexpr double kFarthestM = 1e5;
constexpr double kLeastAreaM2 = 1e-4;

double Cross(const GroundPoint& origin, const GroundPoint& a, const GroundPoint& b) {
  return (a.x_m - origin.x_m) * (b.y_m - origin.y_m) - (a.y_m - origin.y_m) * (b.x_m - origin.x_m);
}

bool Crosses(const Edge& a, const Edge& b) {
  const auto sides = [](const Edge& edge, const Edge& other) {
    return Cross(edge.from, edge.to, other.from) * Cross(edge.from, edge.to, other.to) < 0;
  };
  return sides(a, b) && sides(b, a);
}

Error NoRegion(std::string why) {
  return {kCodeParametersInvalid, std::move(why)};
}

std::string Text(const GroundPoint& point) {
  return fmt::format("({:g}, {:g})", point.x_m, point.y_m);
}

Ring WithoutRepetition(const Ring& ring) {
  Ring kept;
  for (const GroundPoint& corner : ring) {
    if (kept.empty() || Distance(kept.back(), corner) > kTouchingM) kept.push_back(corner);
  }
  while (kept.size() > 1 && Distance(kept.front(), kept.back()) <= kTouchingM) kept.pop_back();
  return kept;
}

Result<> CheckNumbers(const std::string& name, const Ring& ring) {
  for (const GroundPoint& corner : ring) {
    const bool fits = std::abs(corner.x_m) <= kFarthestM && std::abs(corner.y_m) <= kFarthestM;
    if (!fits) {
      return NoRegion(name + " has a corner at " + Text(corner) +
                      "; expected numbers between -100000 and 100000 m");
    }
  }
  return Ok();
}

Result<> CheckRing(const std::string& name, const Ring& ring) {
  if (ring.size() < 3) {
    return NoRegion(
        fmt::format("{} has {}; expected at least 3", name, Counted(ring.size(), "corner")));
  }
  const std::vector<Edge> edges = EdgesOf(ring);
  const std::size_t count = edges.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Edge& next = edges[(i + 1) % count];
    const bool back =
        Distance(next.to, edges[i]) <= kTouchingM || Distance(edges[i].from, next) <= kTouchingM;
    if (back) return NoRegion(name + " turns back on itself at " + Text(next.from));
    for (std::size_t k = i + 2; k < count; ++k) {
      if (i == 0 && k + 1 == count) continue;  // they are neighbours
      if (Distance(edges[i], edges[k]) > kTouchingM) continue;
      return NoRegion(name + " crosses or touches itself near " + Text(edges[k].from));
    }
  }
  if (std::abs(SignedArea(ring)) < kLeastAreaM2) return NoRegion(name + " has no area");
  return Ok();
}

Result<> CheckApart(const std::string& name, const Ring& ring, const std::string& other_name,
                    const Ring& other) {
  for (const Edge& edge : EdgesOf(ring)) {
    for (const Edge& other_edge : EdgesOf(other)) {
      if (Distance(edge, other_edge) > kTouchingM) continue;
      return NoRegion(
          fmt::format("{} crosses or touches {} near {}", name, other_name, Text(edge.from)));
    }
  }
  return Ok();
}

Result<> CheckHole(const Region& region, std::size_t index) {
  const std::string name = fmt::format("hole {}", index + 1);
  const Ring& hole = region.holes[index];
  Result<> apart = CheckApart(name, hole, "the boundary", region.boundary);
  if (!apart) return apart;
  if (!Contains(EdgesOf(region.boundary), hole.front())) {
    return NoRegion(name + " is outside of the boundary");
  }
  for (std::size_t i = 0; i < index; ++i) {
    const std::string other = fmt::format("hole {}", i + 1);
    Result<> holes_apart = CheckApart(name, hole, other, region.holes[i]);
    if (!holes_apart) return holes_apart;
    if (Contains(EdgesOf(region.holes[i]), hole.front())) {
      return NoRegion(name + " is in " + other);
    }
    if (Contains(EdgesOf(hole), region.holes[i].front())) {
      return NoRegion(other + " is in " + name);
    }
  }
  return Ok();
}

}  // namespace

Result<Region> Checked(const Region& region) {
  std::size_t corners = region.boundary.size();
  for (const Ring& hole : region.holes) corners += hole.size();
  if (corners > kMostCorners) {
    return NoRegion(fmt::format("the boundary and its holes have {} corners; expected at most {}",
                                corners, kMostCorners));
  }
  const Result<> numbers = CheckNumbers("the boundary", region.boundary);
  if (!numbers) return numbers.error();
  Region kept{WithoutRepetition(region.boundary), {}};
  const Result<> boundary = CheckRing("the boundary", kept.boundary);
  if (!boundary) return boundary.error();
  for (std::size_t i = 0; i < region.holes.size(); ++i) {
    const std::string name = fmt::format("hole {}", i + 1);
    const Result<> hole_numbers = CheckNumbers(name, region.holes[i]);
    if (!hole_numbers) return hole_numbers.error();
    kept.holes.push_back(WithoutRepetition(region.holes[i]));
    const Result<> ring = CheckRing(name, kept.holes.back());
    if (!ring) return ring.error();
    const Result<> hole = CheckHole(kept, i);
    if (!hole) return hole.error();
  }
  return kept;
}

double Distance(const GroundPoint& a, const GroundPoint& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

double Distance(const GroundPoint& point, const Edge& edge) {
  const double x = edge.to.x_m - edge.from.x_m, y = edge.to.y_m - edge.from.y_m;
  const double square = x * x + y * y;
  if (square == 0) return Distance(point, edge.from);
  const double along = (point.x_m - edge.from.x_m) * x + (point.y_m - edge.from.y_m) * y;
  const double share = std::clamp(along / square, 0.0, 1.0);
  return Distance(point, GroundPoint{edge.from.x_m + share * x, edge.from.y_m + share * y});
}

double Distance(const Edge& a, const Edge& b) {
  if (Crosses(a, b)) return 0;
  return std::min({Distance(a.from, b), Distance(a.to, b), Distance(b.from, a), Distance(b.to, a)});
}

double SignedArea(const Ring& ring) {
  double twice = 0;
  for (const Edge& edge : EdgesOf(ring)) {
    twice += Cross(ring.front(), edge.from, edge.to);
  }
  return twice / 2;
}

std::vector<Edge> EdgesOf(const Ring& ring) {
  std::vector<Edge> edges;
  edges.reserve(ring.size());
  for (std::size_t i = 0; i < ring.size(); ++i) {
    edges.push_back({ring[i], ring[(i + 1) % ring.size()]});
  }
  return edges;
}

std::vector<Edge> EdgesOf(const Region& region) {
  std::vector<Edge> edges = EdgesOf(region.boundary);
  for (const Ring& hole : region.holes) {
    const std::vector<Edge> more = EdgesOf(hole);
    edges.insert(edges.end(), more.begin(), more.end());
  }
  return edges;
}

bool Contains(const std::vector<Edge>& edges, const GroundPoint& point) {
  bool inside = false;
  for (const Edge& edge : edges) {
    if ((edge.from.y_m <= point.y_m) == (edge.to.y_m <= point.y_m)) continue;
    const double share = (point.y_m - edge.from.y_m) / (edge.to.y_m - edge.from.y_m);
    if (edge.from.x_m + share * (edge.to.x_m - edge.from.x_m) > point.x_m) inside = !inside;
  }
  return inside;
}

GroundPoint Turned(const GroundPoint& point, double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  return {c * point.x_m - s * point.y_m, s * point.x_m + c * point.y_m};
}

Region Turned(const Region& region, double angle_rad) {
  Region turned = region;
  for (GroundPoint& corner : turned.boundary) corner = Turned(corner, angle_rad);
  for (Ring& hole : turned.holes) {
    for (GroundPoint& corner : hole) corner = Turned(corner, angle_rad);
  }
  return turned;
}

}  // namespace musher::coverage
