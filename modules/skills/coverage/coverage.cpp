#include "musher/modules/skills/coverage/coverage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "musher/modules/skills/coverage/tour.hpp"

namespace musher::coverage {
namespace {

struct Division {
  double direction_rad = 0;
  std::vector<Cell> cells;
  std::size_t lanes = 0;
  double length_m = 0;  // of all lanes
};

Error Refused(std::string why) {
  return {kCodeParametersInvalid, std::move(why)};
}

// Of the edges, the longest first, without two that are nearly the same; in [0, pi).
std::vector<double> DirectionsOf(const Region& region) {
  constexpr std::size_t kMost = 16;
  constexpr double kSameRad = 0.02;
  std::vector<Edge> edges = EdgesOf(region);
  std::ranges::stable_sort(edges, std::ranges::greater{},
                           [](const Edge& edge) { return Distance(edge.from, edge.to); });
  std::vector<double> directions;
  for (const Edge& edge : edges) {
    const double direction = std::atan2(edge.to.y_m - edge.from.y_m, edge.to.x_m - edge.from.x_m);
    const bool known = std::ranges::any_of(directions, [&](double other) {
      return std::abs(std::remainder(direction - other, std::numbers::pi)) < kSameRad;
    });
    if (!known && directions.size() < kMost) directions.push_back(direction);
  }
  return directions;
}

// `most_slices` limits the time. `whole`: see CellsOf().
Division Divide(const Region& region, const Options& options, double direction_rad,
                double most_slices, bool whole) {
  const FreeSpace space(Turned(region, -direction_rad), options.robot_radius_m);
  constexpr double kSlicesALane = 20;
  constexpr double kCoarsestM = 0.1;
  const double height = space.highest_m() - space.lowest_m();
  const double slice_m =
      std::max(std::min(options.lane_width_m / kSlicesALane, kCoarsestM), height / most_slices);
  Division division{direction_rad, CellsOf(space, options.lane_width_m, slice_m, whole)};
  for (const Cell& cell : division.cells) {
    division.lanes += cell.lanes.size();
    for (const Lane& lane : cell.lanes) division.length_m += lane.x.end_m - lane.x.begin_m;
  }
  return division;
}

// The one with the fewest turns; of the same number, with the shortest lanes.
std::optional<double> BestDirection(const Region& region, const Options& options) {
  constexpr double kSlices = 500;
  std::optional<Division> best;
  for (const double direction : DirectionsOf(region)) {
    Division division = Divide(region, options, direction, kSlices, false);
    if (division.lanes == 0) continue;
    const bool better =
        !best || division.lanes < best->lanes ||
        (division.lanes == best->lanes && division.length_m < best->length_m - 0.01);
    if (better) best = std::move(division);
  }
  return best ? std::optional(best->direction_rad) : std::nullopt;
}

}  // namespace

Result<Plan> PlanCoverage(const Region& region, const Options& options,
                          const std::optional<GroundPoint>& start) {
  const Result<Region> checked = Checked(region);
  if (!checked) return checked.error();
  if (!(options.lane_width_m > 0) || !std::isfinite(options.lane_width_m)) {
    return Refused(
        fmt::format("lane_width is {:g} m; expected more than 0 m", options.lane_width_m));
  }
  if (!(options.robot_radius_m >= 0) || !std::isfinite(options.robot_radius_m)) {
    return Refused(
        fmt::format("robot_radius is {:g} m; expected 0 m or more", options.robot_radius_m));
  }
  const auto direction = BestDirection(checked.value(), options);
  if (!direction) {
    return Refused(fmt::format("a robot with a radius of {:g} m does not fit into the boundary",
                               options.robot_radius_m));
  }
  constexpr double kSlices = 4000;
  const Division division = Divide(checked.value(), options, *direction, kSlices, true);
  if (division.lanes > kMostLanes || division.cells.size() > kMostCells) {
    return Refused(fmt::format(
        "the region needs {} lanes in {} parts; expected at most {} and {}: a larger lane_width or "
        "a simpler region has fewer",
        division.lanes, division.cells.size(), kMostLanes, kMostCells));
  }
  const Region turned = Turned(checked.value(), -*direction);
  const FreeSpace space(turned, options.robot_radius_m);
  Router router(space, turned);
  const auto turned_start = start ? std::optional(Turned(*start, -*direction)) : std::nullopt;
  const Tour tour = TourOf(division.cells, turned_start, router);
  Plan plan;
  for (const GroundPoint& corner : tour.corners) plan.corners.push_back(Turned(corner, *direction));
  for (std::size_t i = 0; i < tour.on_lane.size(); ++i) {
    const double length = Distance(tour.corners[i], tour.corners[i + 1]);
    plan.length_m += length;
    if (!tour.on_lane[i]) plan.between_m += length;
    if (tour.on_lane[i]) ++plan.lanes;
  }
  plan.on_lane = tour.on_lane;
  for (const Edge& lane : tour.lanes_left_out) {
    plan.lanes_left_out.push_back({Turned(lane.from, *direction), Turned(lane.to, *direction)});
  }
  plan.direction_rad = *direction;
  plan.cells = tour.cells;
  plan.cells_left_out = tour.cells_left_out;
  return plan;
}

std::vector<GroundPoint> Interpolated(const std::vector<GroundPoint>& corners, double distance_m) {
  std::vector<GroundPoint> points;
  for (const GroundPoint& corner : corners) {
    if (points.empty()) {
      points.push_back(corner);
      continue;
    }
    const GroundPoint from = points.back();
    const double length = Distance(from, corner);
    if (length == 0) continue;
    const auto parts = static_cast<std::size_t>(std::ceil(length / distance_m - 1e-9));
    for (std::size_t i = 1; i < parts; ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(parts);
      points.push_back(
          {from.x_m + share * (corner.x_m - from.x_m), from.y_m + share * (corner.y_m - from.y_m)});
    }
    points.push_back(corner);
  }
  return points;
}

}  // namespace musher::coverage
