#include "musher/navigation/route/route_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace musher::navigation {
namespace {

struct Flat {
  double x = 0, y = 0;
};

Flat Step(const Point& from, const Point& to) {
  return {to.x_m - from.x_m, to.y_m - from.y_m};
}
double Dot(const Flat& a, const Flat& b) {
  return a.x * b.x + a.y * b.y;
}
double LengthOf(const Flat& a) {
  return std::hypot(a.x, a.y);
}
Flat Direction(const Flat& a) {
  const double length = LengthOf(a);
  return length > 0 ? Flat{a.x / length, a.y / length} : Flat{};
}

// Whether a place is beside the line from `a` to `b`, past its begin.
bool IsAlong(const Point& a, const Point& b, const Point& at, double within_m) {
  const Flat ahead = Direction(Step(a, b)), to = Step(a, at);
  const double along_m = Dot(to, ahead);
  return along_m > 0 && along_m <= LengthOf(Step(a, b)) &&
         std::abs(to.y * ahead.x - to.x * ahead.y) <= within_m;
}

}  // namespace

RouteTracker::RouteTracker(std::shared_ptr<const RouteGraph> graph, Route route,
                           const TrackRules& rules, std::size_t reached)
    : graph_(std::move(graph)), route_(std::move(route)), rules_(rules), next_(reached) {}

bool RouteTracker::Update(const Point& at) {
  const std::size_t before = next_;
  while (!done() && IsReached(at)) ++next_;
  return next_ != before;
}

bool RouteTracker::IsReached(const Point& at) const {
  const auto place_of = [this](std::size_t i) { return graph_->nodes[route_.nodes[i]].at; };
  const bool is_first = next_ == 0, is_last = next_ + 1 == route_.nodes.size();
  const Point node = place_of(next_);
  const Flat from_node = Step(node, at);
  const double apart_m = LengthOf(from_node);
  if (is_first || is_last) {
    if (apart_m <= rules_.end_reached_m) return true;
    return !is_last && IsAlong(node, place_of(1), at, rules_.reached_m);
  }
  const Point before = place_of(next_ - 1), behind = place_of(next_ + 1);
  // Ways there and back may lie beside each other.
  if (IsAlong(node, behind, at, rules_.reached_m) && !IsAlong(before, node, at, rules_.reached_m)) {
    return true;
  }
  if (apart_m > rules_.reached_m) return false;
  const Flat in = Direction(Step(before, node)), out = Direction(Step(node, behind));
  const Flat across{in.x + out.x, in.y + out.y};
  // Back on the way it has come: the line that halves the corner has no direction.
  if (LengthOf(across) < 1e-6) return apart_m <= rules_.end_reached_m;
  return Dot(from_node, across) >= 0;
}

std::optional<std::size_t> RouteTracker::last_node() const {
  if (next_ == 0) return std::nullopt;
  return route_.nodes[next_ - 1];
}
std::optional<std::size_t> RouteTracker::next_node() const {
  if (done()) return std::nullopt;
  return route_.nodes[next_];
}
std::optional<std::size_t> RouteTracker::edge() const {
  if (next_ == 0 || done()) return std::nullopt;
  return route_.edges[next_ - 1];
}

bool RouteTracker::IsClosed(const EdgeChanges& changes) const {
  const std::size_t from = next_ == 0 ? 0 : next_ - 1;
  return std::any_of(
      route_.edges.begin() + static_cast<std::ptrdiff_t>(std::min(from, route_.edges.size())),
      route_.edges.end(), [&changes](std::size_t edge) { return changes.closed.contains(edge); });
}

}  // namespace musher::navigation
