#include "musher/modules/meilin/nodes/edge.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace musher::meilin {
namespace {

constexpr double kOnUpperM = 0.05;    // so far over the upper cell the hull rests on it
constexpr double kToUpperM = 0.22;    // where the wheels of the lower side still stand below
constexpr double kNearUpperM = 0.18;  // from here on it does not drive there first
constexpr double kBackM = -0.272;  // where these hang, and the hull still rests on the upper cell
constexpr double kIsBackM = -0.252;
constexpr double kAllLowerM = -0.24;  // before it all wheels stand on the lower cell
constexpr double kAcrossRad = 0.2;    // of the heading, from a right angle to the edge
constexpr double kRollsMm = 24;       // a longer wheel does not roll over the edge
constexpr double kBeforeMm = 10;      // so far below the upper cell the hull is not over it
constexpr double kHeightMm = 130;     // of the body, from where it should be

// Outside the grid there is the ground.
double HeightAt(const Grid& grid, Cell cell) {
  return grid.HeightMm(cell);
}

std::pair<std::size_t, std::size_t> WheelsTowards(Direction direction) {
  switch (direction) {
    case Direction::kForward:
      return {0, 1};
    case Direction::kLeft:
      return {0, 2};
    case Direction::kRight:
      return {1, 3};
    case Direction::kBackward:
      return {2, 3};
  }
  return {0, 1};
}

// The two wheels of a side, as one.
struct Pair {
  double least_mm = 0;
  double most_mm = 0;
};
Pair PairOf(const Wheels& wheels, Direction direction) {
  const auto [a, b] = WheelsTowards(direction);
  return {std::min(wheels.mm.at(a), wheels.mm.at(b)), std::max(wheels.mm.at(a), wheels.mm.at(b))};
}

MoveGoal To(Point2 at, double yaw_rad) {
  return {at.x_m, at.y_m, yaw_rad};
}

// Of the wheels that stand on the lower cell while the hull is over the upper one.
double ClimbMm(const Edge& edge) {
  return edge.step_mm <= kLowStepMm ? kLowClimbMm : kHighClimbMm;
}

// `offset_m` from the edge, on the line of both centres.
Point2 AtOffset(const Grid& grid, const Edge& edge, double offset_m) {
  const Point2 lower = grid.Centre(edge.lower);
  const double way_m = grid.size_m / 2 + offset_m;
  const double yaw_rad = YawOf(edge.up);
  return {lower.x_m + way_m * std::cos(yaw_rad), lower.y_m + way_m * std::sin(yaw_rad)};
}

OffEdge Unclear(OffEdge way, const std::string& why) {
  way.unclear = way.text + ": " + why + "; put it on a cell by hand";
  return way;
}

// Level ground: wheels that are out are lowered at the centre.
OffEdge OnLevel(const Settings& settings, const PoseFix& pose,
                const std::optional<Wheels>& wheels) {
  OffEdge way;
  const std::optional<Cell> cell = settings.grid.CellAt({pose.x_m, pose.y_m});
  if (!cell) return way;
  way.to = *cell;
  if (!wheels || LongestMm(*wheels) <= kLongWheelMm) return way;
  way.text = fmt::format("on {}, wheels {}", CellText(*cell), WheelsText(*wheels));
  if (!settings.grid.IsAtCentre({pose.x_m, pose.y_m}, *cell)) {
    way.next = {To(settings.grid.Centre(*cell), pose.yaw_rad), 0};
  } else {
    way.next = {std::nullopt, settings.normal_height_mm};
  }
  return way;
}

// Along the line of both cells, with the heading that it has.
OffEdge OverEdge(const Settings& settings, const PoseFix& pose, const Edge& edge,
                 const Wheels& wheels, bool upper_blocked, OffEdge way) {
  const Direction body = NearestDirection(YawOf(edge.up) - pose.yaw_rad);
  const Pair upper = PairOf(wheels, body);
  const Pair lower = PairOf(wheels, Opposite(body));
  const double upper_mm = HeightAt(settings.grid, edge.upper);
  const double lower_mm = HeightAt(settings.grid, edge.lower);
  const double z_mm = pose.z_m * 1000;
  const bool carried = std::isnan(z_mm) || std::abs(z_mm - upper_mm) <= kHeightMm;
  const OffEdgeStep to_upper{To(settings.grid.Centre(edge.upper), pose.yaw_rad), 0};
  const double longest_mm = std::max(upper.most_mm, lower.most_mm);
  const double shortest_mm = std::min(upper.least_mm, lower.least_mm);
  // Before the edge they are not on it yet, and have to roll onto it.
  const double on_mm = edge.offset_m <= kAllLowerM ? kRollsMm : kLongWheelMm;
  if (upper.most_mm <= on_mm) {
    way.to = edge.upper;
    if (!carried) return Unclear(way, fmt::format("the body is at {:.0f} mm", z_mm));
    const bool stands = lower.least_mm >= edge.step_mm - kLongWheelMm;
    if (upper_blocked && stands) {
      way.to = edge.lower;
      if (edge.offset_m > kIsBackM) {
        way.next = {To(AtOffset(settings.grid, edge, kBackM), pose.yaw_rad), 0};
      } else {
        way.next = {std::nullopt, ClimbMm(edge)};
      }
    } else if (edge.offset_m < kNearUpperM && stands) {
      way.next = {To(AtOffset(settings.grid, edge, kToUpperM), pose.yaw_rad), 0};
    } else if (edge.offset_m < kOnUpperM) {
      return Unclear(way, "nothing holds the wheels of the lower side");
    } else if (longest_mm > kRollsMm) {
      way.next = {std::nullopt, kShortWheelMm};
    } else {
      way.next = to_upper;
    }
    return way;
  }
  if (edge.offset_m >= -kAllLowerM && longest_mm - shortest_mm <= kLongWheelMm) {
    way.to = edge.upper;  // lifted, on the upper cell
    way.next = to_upper;
    return way;
  }
  way.to = edge.lower;
  if (edge.offset_m > kAllLowerM) return Unclear(way, "the wheels of the upper side are long");
  if (!std::isnan(z_mm) && (z_mm < lower_mm || z_mm > lower_mm + kHighClimbMm + kHeightMm)) {
    return Unclear(way, fmt::format("the body is at {:.0f} mm", z_mm));
  }
  const double down_mm = ClimbMm(edge);
  if (shortest_mm < down_mm - kLongWheelMm / 2) {
    way.next = {std::nullopt, down_mm};
  } else {
    way.next = {To(settings.grid.Centre(edge.lower), pose.yaw_rad), 0};
  }
  return way;
}

}  // namespace

double LongestMm(const Wheels& wheels) {
  return *std::ranges::max_element(wheels.mm);
}

std::string WheelsText(const Wheels& wheels) {
  return fmt::format("{:.0f}, {:.0f}, {:.0f}, {:.0f} mm", wheels.mm[0], wheels.mm[1], wheels.mm[2],
                     wheels.mm[3]);
}

EdgeReading FindEdge(const Grid& grid, Point2 at) {
  EdgeReading reading;
  const std::optional<Cell> here = grid.CellAt(at);
  if (!here) return reading;
  const Point2 centre = grid.Centre(*here);
  const double here_mm = HeightAt(grid, *here);
  std::vector<Cell> near;
  for (int row = -1; row <= 1; ++row) {
    for (int col = -1; col <= 1; ++col) {
      const Cell cell{here->row + row, here->col + col};
      const Point2 other = grid.Centre(cell);
      const bool over = std::abs(at.x_m - other.x_m) < grid.size_m / 2 + kHullHalfM &&
                        std::abs(at.y_m - other.y_m) < grid.size_m / 2 + kHullHalfM;
      if (over && HeightAt(grid, cell) != here_mm) near.push_back(cell);
    }
  }
  if (near.empty()) return reading;
  const std::optional<Direction> way = DirectionTo(*here, near.front());
  if (near.size() > 1 || !way || !IsInside(near.front())) {
    reading.unclear = "at a corner or at the border of the field, near " + CellText(*here);
    return reading;
  }
  const bool up = HeightAt(grid, near.front()) > here_mm;
  Edge edge;
  edge.upper = up ? near.front() : *here;
  edge.lower = up ? *here : near.front();
  edge.up = up ? *way : Opposite(*way);
  edge.step_mm = std::abs(HeightAt(grid, near.front()) - here_mm);
  const double yaw_rad = YawOf(edge.up);
  const Point2 lower = up ? centre : grid.Centre(near.front());
  edge.offset_m = (at.x_m - lower.x_m) * std::cos(yaw_rad) +
                  (at.y_m - lower.y_m) * std::sin(yaw_rad) - grid.size_m / 2;
  reading.edge = edge;
  return reading;
}

namespace {

// A body that is lower than the upper cell stands before that cell, and is not over it.
bool StandsBefore(const Edge& edge, const Grid& grid, const PoseFix& pose,
                  const std::optional<Wheels>& wheels) {
  if (edge.offset_m > kAllLowerM) return false;
  const double lower_mm = HeightAt(grid, edge.lower);
  const bool known = !std::isnan(pose.z_m);
  if (!known && !wheels) return false;
  const double body_mm = known ? pose.z_m * 1000 : lower_mm + LongestMm(*wheels);
  return body_mm < lower_mm + edge.step_mm - kBeforeMm;
}

}  // namespace

OffEdge PlanOffEdge(const Settings& settings, const PoseFix& pose,
                    const std::optional<Wheels>& wheels, bool upper_blocked) {
  const EdgeReading found = FindEdge(settings.grid, {pose.x_m, pose.y_m});
  const bool before = found.edge && StandsBefore(*found.edge, settings.grid, pose, wheels);
  if (!found.on_edge() || before) return OnLevel(settings, pose, wheels);
  OffEdge way;
  way.on_edge = true;
  const std::string legs = wheels ? "wheels " + WheelsText(*wheels) : "wheels unknown";
  if (!found.edge) {
    way.text = found.unclear + ", " + legs;
    return Unclear(way, "no way off is certain");
  }
  way.text = fmt::format("on the edge of {} and {}, {}", CellText(found.edge->upper),
                         CellText(found.edge->lower), legs);
  way.to = found.edge->offset_m >= 0 ? found.edge->upper : found.edge->lower;
  if (!wheels) return Unclear(way, "the wheels do not report");
  const double turned_rad = YawOf(found.edge->up) - pose.yaw_rad;
  if (YawDistance(turned_rad, SnapYaw(turned_rad)) > kAcrossRad) {
    return Unclear(way, fmt::format("it looks across the edge, {:.2f} rad", pose.yaw_rad));
  }
  return OverEdge(settings, pose, *found.edge, *wheels, upper_blocked, std::move(way));
}

}  // namespace musher::meilin
