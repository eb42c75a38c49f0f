#include "musher/modules/skills/coverage/free_space.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>

namespace musher::coverage {
namespace {

constexpr double kToleranceM = 1e-6;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// The hull of some numbers.
struct Hull {
  double least = kInfinite;
  double most = -kInfinite;

  void Add(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
};

// The x of the line y = y_m that are nearer to the edge than the radius. They are one interval, as
// the points around an edge are convex.
Hull NearTo(const Edge& edge, double radius_m, double y_m) {
  Hull near;
  for (const GroundPoint& end : {edge.from, edge.to}) {
    const double y = y_m - end.y_m;
    if (std::abs(y) >= radius_m) continue;
    const double half = std::sqrt(radius_m * radius_m - y * y);
    near.Add(end.x_m - half);
    near.Add(end.x_m + half);
  }
  const double length = Distance(edge.from, edge.to);
  const double across_x = -(edge.to.y_m - edge.from.y_m) / length * radius_m;
  const double across_y = (edge.to.x_m - edge.from.x_m) / length * radius_m;
  const std::array<GroundPoint, 4> corners{
      GroundPoint{edge.from.x_m + across_x, edge.from.y_m + across_y},
      GroundPoint{edge.to.x_m + across_x, edge.to.y_m + across_y},
      GroundPoint{edge.to.x_m - across_x, edge.to.y_m - across_y},
      GroundPoint{edge.from.x_m - across_x, edge.from.y_m - across_y}};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const GroundPoint &a = corners[i], &b = corners[(i + 1) % corners.size()];
    if ((a.y_m <= y_m) == (b.y_m <= y_m)) continue;
    near.Add(a.x_m + (y_m - a.y_m) / (b.y_m - a.y_m) * (b.x_m - a.x_m));
  }
  return near;
}

}  // namespace

FreeSpace::FreeSpace(const Region& region, double radius_m)
    : edges_(EdgesOf(region)), radius_m_(radius_m) {
  Hull y;
  for (const GroundPoint& corner : region.boundary) y.Add(corner.y_m);
  lowest_m_ = y.least;
  highest_m_ = y.most;
}

std::vector<Interval> FreeSpace::At(double y_m) const {
  std::vector<double> crossings;
  std::vector<Interval> blocked;
  for (const Edge& edge : edges_) {
    if ((edge.from.y_m <= y_m) != (edge.to.y_m <= y_m)) {
      const double share = (y_m - edge.from.y_m) / (edge.to.y_m - edge.from.y_m);
      crossings.push_back(edge.from.x_m + share * (edge.to.x_m - edge.from.x_m));
    }
    const Hull near = NearTo(edge, radius_m_, y_m);
    if (near.least < near.most) blocked.push_back({near.least, near.most});
  }
  std::ranges::sort(crossings);
  std::ranges::sort(blocked, {}, &Interval::begin_m);
  std::vector<Interval> free;
  for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
    double begin = crossings[i];
    const double end = crossings[i + 1];
    for (const Interval& part : blocked) {
      if (part.end_m <= begin || part.begin_m >= end) continue;
      if (part.begin_m - begin > kToleranceM) free.push_back({begin, part.begin_m});
      begin = std::max(begin, part.end_m);
    }
    if (end - begin > kToleranceM) free.push_back({begin, end});
  }
  return free;
}

bool FreeSpace::Passes(const GroundPoint& a, const GroundPoint& b) const {
  const Edge way{a, b};
  const double length = Distance(a, b);
  const double x = length > 0 ? (b.x_m - a.x_m) / length : 1;
  const double y = length > 0 ? (b.y_m - a.y_m) / length : 0;
  const auto outside = [&](double first, double second, double least, double most) {
    return (first < least && second < least) || (first > most && second > most);
  };
  for (const Edge& edge : edges_) {
    // Along the path and across it: most edges are far from it by one of them.
    const GroundPoint from{edge.from.x_m - a.x_m, edge.from.y_m - a.y_m};
    const GroundPoint to{edge.to.x_m - a.x_m, edge.to.y_m - a.y_m};
    if (outside(x * from.y_m - y * from.x_m, x * to.y_m - y * to.x_m, -radius_m_, radius_m_) ||
        outside(x * from.x_m + y * from.y_m, x * to.x_m + y * to.y_m, -radius_m_,
                length + radius_m_)) {
      continue;
    }
    if (Distance(edge, way) < radius_m_ - kToleranceM) return false;
  }
  return true;
}

bool FreeSpace::Clear(const GroundPoint& a, const GroundPoint& b) const {
  return Passes(a, b) && Contains(edges_, a);
}

Router::Router(const FreeSpace& space, const Region& region) : space_(space) {
  AddNodes(region.boundary, false);
  for (const Ring& hole : region.holes) AddNodes(hole, true);
  neighbours_.resize(nodes_.size());
  for (Node i = 0; i < nodes_.size(); ++i) {
    for (Node k = i + 1; k < nodes_.size(); ++k) {
      if (!space_.Passes(nodes_[i], nodes_[k])) continue;
      neighbours_[i].push_back(k);
      neighbours_[k].push_back(i);
    }
  }
}

// On an arc around each corner that can be in the way.
void Router::AddNodes(const Ring& ring, bool hole) {
  constexpr double kStepRad = std::numbers::pi / 6;
  // So that the chords between the nodes keep the radius, with a little more.
  const double radius_m = space_.radius_m() / std::cos(kStepRad / 2) + 1e-3;
  // Seen along the ring, the region is on the left of a boundary and on the right of a hole.
  const bool forwards = (SignedArea(ring) > 0) != hole;
  const std::size_t count = ring.size();
  for (std::size_t i = 0; i < count; ++i) {
    GroundPoint before = ring[(i + count - 1) % count], after = ring[(i + 1) % count];
    if (!forwards) std::swap(before, after);
    const double in = std::atan2(ring[i].y_m - before.y_m, ring[i].x_m - before.x_m);
    const double out = std::atan2(after.y_m - ring[i].y_m, after.x_m - ring[i].x_m);
    const double turn = std::remainder(out - in, 2 * std::numbers::pi);
    if (turn >= 0) continue;  // the region is convex here
    const int steps = static_cast<int>(std::ceil(-turn / kStepRad));
    for (int k = 0; k <= steps; ++k) {
      const double angle = in + std::numbers::pi / 2 + turn * k / steps;
      const GroundPoint node{ring[i].x_m + radius_m * std::cos(angle),
                             ring[i].y_m + radius_m * std::sin(angle)};
      if (space_.Clear(node, node)) nodes_.push_back(node);
    }
  }
}

const std::vector<Router::Node>& Router::Visible(const GroundPoint& point) {
  const auto [place, is_new] = visible_.try_emplace({point.x_m, point.y_m});
  if (is_new) {
    for (Node node = 0; node < nodes_.size(); ++node) {
      if (space_.Passes(nodes_[node], point)) place->second.push_back(node);
    }
  }
  return place->second;
}

Router::Tree Router::From(const GroundPoint& point) {
  Tree tree{std::vector<double>(nodes_.size(), kInfinite),
            std::vector<std::optional<Node>>(nodes_.size())};
  for (const Node node : Visible(point)) tree.length_m[node] = Distance(point, nodes_[node]);
  std::vector<bool> done(nodes_.size(), false);
  for (;;) {
    std::optional<Node> nearest;
    for (Node node = 0; node < nodes_.size(); ++node) {
      if (done[node] || tree.length_m[node] == kInfinite) continue;
      if (!nearest || tree.length_m[node] < tree.length_m[*nearest]) nearest = node;
    }
    if (!nearest) return tree;
    done[*nearest] = true;
    for (const Node next : neighbours_[*nearest]) {
      const double length = tree.length_m[*nearest] + Distance(nodes_[*nearest], nodes_[next]);
      if (length >= tree.length_m[next]) continue;
      tree.length_m[next] = length;
      tree.before[next] = nearest;
    }
  }
}

std::pair<std::optional<Router::Node>, double> Router::Last(const Tree& tree,
                                                            const GroundPoint& to) {
  std::pair<std::optional<Node>, double> last{std::nullopt, kInfinite};
  for (const Node node : Visible(to)) {
    const double length = tree.length_m[node] + Distance(nodes_[node], to);
    if (length < last.second) last = {node, length};
  }
  return last;
}

std::vector<GroundPoint> Router::Route(const GroundPoint& a, const GroundPoint& b) {
  if (space_.Clear(a, b)) return {a, b};
  const Tree tree = From(a);
  auto [node, length] = Last(tree, b);
  if (!node) return {};
  std::vector<GroundPoint> route{b};
  for (; node; node = tree.before[*node]) route.push_back(nodes_[*node]);
  route.push_back(a);
  std::ranges::reverse(route);
  return route;
}

std::vector<double> Router::Lengths(const GroundPoint& from, const std::vector<GroundPoint>& to) {
  const Tree tree = From(from);
  std::vector<double> lengths;
  lengths.reserve(to.size());
  for (const GroundPoint& point : to) {
    lengths.push_back(space_.Clear(from, point) ? Distance(from, point) : Last(tree, point).second);
  }
  return lengths;
}

}  // namespace musher::coverage
