#include "musher/modules/navigation/planner_server/planner_work.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "musher/navigation/masks/filter_mask.hpp"
#include "musher/navigation/navigation_fault.hpp"
#include "musher/navigation/place_text.hpp"
#include "musher/navigation/planner/octree_map.hpp"

namespace musher::navigation {
namespace {

constexpr std::size_t kMostCopied = 4 << 20;  // cells of a map that is copied for a request
constexpr double kAroundPathM = 10;           // the part of a larger map that is copied
constexpr double kAroundRobotM = 25;          // if that is too large as well
constexpr double kLocalM = 5;                 // first the part so near to the robot
constexpr double kNearM = 8;                  // what is seen there counts more than all that is

PlannerRules RulesOf(const PlannerRobot& robot) {
  PlannerRules rules;
  rules.radius_m = robot.radius_m + robot.margin_m;
  rules.comfort_m = robot.comfort_m;
  rules.start_within_m = robot.margin_m;
  rules.heading = robot.flies ? Heading::kTurning : Heading::kAlong;
  return rules;
}

// The layers of a map between the ground and the ceiling, and a blocked one below and above them.
Result<CellMap> BetweenGroundAndCeiling(const CellMap& map, double ceiling_m) {
  constexpr double kRounding = 1e-6;
  const double ground = -map.origin.at.z_m / map.resolution_m;
  const int below = static_cast<int>(std::floor(ground + kRounding)) - 1;
  const int above = static_cast<int>(std::ceil(ground + ceiling_m / map.resolution_m - kRounding));
  CellMap between = map;
  between.origin.at.z_m += below * map.resolution_m;
  between.size_z = above - below + 1;
  const std::int64_t layer = std::int64_t{map.size_x} * map.size_y;
  if (layer * between.size_z > kMostCells) {
    return MakeError(
        Fault::kMap,
        fmt::format("point cloud: {} x {} x {} cells of {} m, at most {} in all; use "
                    "a coarser cloud_resolution_m",
                    map.size_x, map.size_y, between.size_z, map.resolution_m, kMostCells));
  }
  between.blocked.assign(static_cast<std::size_t>(layer * between.size_z), 0);
  for (int z = 0; z < between.size_z; ++z) {
    const auto to = between.blocked.begin() + static_cast<std::ptrdiff_t>(z * layer);
    const int from = below + z;
    if (z == 0 || z == between.size_z - 1) {
      std::fill_n(to, layer, 1);
    } else if (from >= 0 && from < map.size_z) {
      std::copy_n(map.blocked.begin() + static_cast<std::ptrdiff_t>(from * layer), layer, to);
    }
  }
  return between;
}

// What the scan has seen, as far as it is remembered, and the map does not have. For a flyer its
// columns: a planar scan does not say how high a thing is.
std::vector<Point> NewlySeen(const Planner& planner, const std::vector<Point>& seen, bool flies) {
  const CellMap& map = planner.clearance().map();
  std::vector<Point> nearby = NewPoints(seen, planner.clearance(), 2 * map.resolution_m);
  if (!flies) return nearby;
  std::vector<Point> columns;
  for (const Point& point : nearby) {
    for (int z = 0; z < map.size_z; ++z) {
      columns.push_back({point.x_m, point.y_m, map.CentreOf({0, 0, z}).z_m});
    }
  }
  return columns;
}

// Whether the points are at least `keep_m` from a path.
bool IsClear(const Path& path, const std::vector<Point>& points, double keep_m) {
  for (const Point& point : points) {
    for (std::size_t i = 0; i < path.size(); ++i) {
      const Point &a = path[i == 0 ? 0 : i - 1].at, &b = path[i].at;
      const Point way{b.x_m - a.x_m, b.y_m - a.y_m, b.z_m - a.z_m};
      const double square = way.x_m * way.x_m + way.y_m * way.y_m + way.z_m * way.z_m;
      const double along = (point.x_m - a.x_m) * way.x_m + (point.y_m - a.y_m) * way.y_m +
                           (point.z_m - a.z_m) * way.z_m;
      const double share = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0;
      if (Distance(Between(a, b, share), point) < keep_m) return false;
    }
  }
  return true;
}

// A part of the map in which a path is planned again, and what of the first path follows it.
struct Part {
  CellMap map;
  Pose goal;
  std::size_t rest = 0;  // the first pose of the path that is behind `goal`
};

// The map within a distance of these places.
CellMap Around(const CellMap& map, const Path& places, double around_m) {
  const int cells = static_cast<int>(std::ceil(around_m / map.resolution_m));
  Cell least = map.CellOf(places[0].at), most = least;
  for (const Pose& pose : places) {
    const Cell cell = map.CellOf(pose.at);
    least = {std::min(least.x, cell.x), std::min(least.y, cell.y), 0};
    most = {std::max(most.x, cell.x), std::max(most.y, cell.y), 0};
  }
  return WindowOf(map, {least.x - cells, least.y - cells, 0}, {most.x + cells, most.y + cells, 0});
}

// The whole map if it is small enough, else what is around the path, else what is around the robot.
Part PartOf(const CellMap& map, const Path& path, const Pose& start) {
  if (map.count() <= kMostCopied) return {map, path.back(), path.size()};
  CellMap along = Around(map, path, kAroundPathM);
  if (along.count() <= kMostCopied) return {std::move(along), path.back(), path.size()};
  std::size_t last = 0;  // pose that is well inside of the part
  while (last + 1 < path.size() &&
         Distance(path[last + 1].at, start.at) < kAroundRobotM - kAroundPathM / 2) {
    ++last;
  }
  return {Around(map, {start}, kAroundRobotM), path[last], last + 1};
}

// What is around the robot, if the path has left all that is seen within it.
std::optional<Part> LocalPartOf(const CellMap& map, const Path& path, const Pose& start,
                                const std::vector<Point>& seen, double keep_m) {
  std::size_t last = 0;  // pose that is well inside of the part
  while (last + 1 < path.size() && Distance(path[last + 1].at, start.at) < kLocalM - 2 * keep_m) {
    ++last;
  }
  const Path rest(path.begin() + static_cast<std::ptrdiff_t>(last), path.end());
  if (last == 0 || !IsClear(rest, seen, keep_m)) return std::nullopt;
  return Part{Around(map, {start}, kLocalM), path[last], last + 1};
}

std::optional<Plan> FindAroundIn(Part part, const PathRequest& request, const Plan& plan,
                                 const std::vector<Point>& seen, const PlannerRobot& robot,
                                 const std::function<bool()>& stop) {
  BlockPoints(seen, part.map);
  const auto blocked = Planner::Make(std::move(part.map), RulesOf(robot), stop);
  if (!blocked) return std::nullopt;
  auto around = blocked.value().Find(request.start, part.goal, stop);
  if (!around) return std::nullopt;
  Plan found = std::move(around).value();
  for (std::size_t i = part.rest; i < plan.path.size(); ++i) {
    found.length_m += Distance(found.path.back().at, plan.path[i].at);
    found.path.push_back(plan.path[i]);
  }
  return found;
}

// The rims of the bodies of other robots, and their middles; in every layer of the map.
std::vector<Point> BodiesOf(const std::vector<RobotIntent>& others, const CellMap& map) {
  std::vector<Point> points;
  for (const RobotIntent& other : others) {
    const int around = std::max(8, static_cast<int>(2 * M_PI * other.radius_m / map.resolution_m));
    for (int i = 0; i <= around; ++i) {
      const double angle = 2 * M_PI * i / around, away_m = i == around ? 0 : other.radius_m;
      Point at{other.at.x_m + away_m * std::cos(angle), other.at.y_m + away_m * std::sin(angle), 0};
      for (int z = 0; z < map.size_z; ++z) {
        at.z_m = map.CentreOf({0, 0, z}).z_m;
        points.push_back(at);
      }
    }
  }
  return points;
}

// How far each cell is from the path of one robot.
Clearance AwayFromPath(const RobotIntent& other, CellMap map) {
  std::fill(map.blocked.begin(), map.blocked.end(), 0);
  constexpr double kLongestM = 100;  // of the path; what is farther away does not matter yet
  std::vector<Point> places = {other.at};
  double left_m = kLongestM;
  for (const Point& to : other.path) {
    const Point from = places.back();
    const double length_m = Distance(from, to);
    if (length_m > left_m) break;
    left_m -= length_m;
    const int steps = static_cast<int>(length_m / map.resolution_m) + 1;
    for (int i = 1; i <= steps; ++i) {
      places.push_back(Between(from, to, static_cast<double>(i) / steps));
    }
  }
  BlockPoints(places, map);
  return Clearance(std::move(map));
}

// A path around what is seen, in the part near the robot; nothing where there is none that is not
// much longer.
std::optional<Plan> FindLocally(const Planner& planner, const PathRequest& request,
                                const Plan& plan, const std::vector<Point>& seen,
                                const PlannerRobot& robot, const std::function<bool()>& stop) {
  constexpr double kMuchLonger = 1.5;
  const double keep_m = robot.radius_m + robot.margin_m;
  auto local = LocalPartOf(planner.clearance().map(), plan.path, request.start, seen, keep_m);
  if (!local) return std::nullopt;
  auto around = FindAroundIn(std::move(*local), request, plan, seen, robot, stop);
  const bool longer = around && around->length_m > kMuchLonger * plan.length_m + kLocalM;
  return longer ? std::nullopt : std::move(around);
}

// The same, also farther away.
std::optional<Plan> FindAround(const Planner& planner, const PathRequest& request, const Plan& plan,
                               const std::vector<Point>& seen, const PlannerRobot& robot,
                               const std::function<bool()>& stop) {
  auto local = FindLocally(planner, request, plan, seen, robot, stop);
  if (local) return local;
  return FindAroundIn(PartOf(planner.clearance().map(), plan.path, request.start), request, plan,
                      seen, robot, stop);
}

// What is left of the earlier path, from where the robot is; nothing if the robot has left it.
std::optional<Plan> RestOf(const PathRequest& request, const Clearance& clearance, double keep_m) {
  constexpr double kOnPathM = 0.5;
  double least_m = kOnPathM;
  std::size_t nearest = request.before.size();
  for (std::size_t i = 0; i < request.before.size(); ++i) {
    const double away_m = Distance(request.before[i].at, request.start.at);
    if (away_m >= least_m) continue;
    least_m = away_m;
    nearest = i;
  }
  if (nearest + 1 >= request.before.size()) return std::nullopt;
  Plan rest;
  rest.path.assign(request.before.begin() + static_cast<std::ptrdiff_t>(nearest),
                   request.before.end());
  rest.path.front() = request.start;
  if (!clearance.FitsAlong(rest.path[0].at, rest.path[1].at, keep_m)) return std::nullopt;
  for (std::size_t i = 1; i < rest.path.size(); ++i) {
    rest.length_m += Distance(rest.path[i - 1].at, rest.path[i].at);
  }
  return rest;
}

Result<> CheckAltitude(const Pose& goal, const PlannerConfig& config) {
  if (goal.at.z_m > 0 && goal.at.z_m <= config.ceiling_m) return Ok();
  return MakeError(Fault::kGoalOutside,
                   fmt::format("goal: its altitude is {} m, expected more than 0 and at most {} m",
                               MetresText(goal.at.z_m), MetresText(config.ceiling_m)));
}

PathReply Refused(const Error& error) {
  return {error, ErrorCodeOf(error), false};
}

}  // namespace

std::uint16_t ErrorCodeOf(const Error& error) {
  switch (static_cast<Fault>(error.code)) {
    case Fault::kIdentifier:
      return PathCode::kInvalidPlanner;
    case Fault::kFrame:
    case Fault::kOdometry:
      return PathCode::kTfError;
    case Fault::kOutside:
      return PathCode::kStartOutsideMap;
    case Fault::kGoalOutside:
      return PathCode::kGoalOutsideMap;
    case Fault::kStartBlocked:
      return PathCode::kStartOccupied;
    case Fault::kGoalBlocked:
      return PathCode::kGoalOccupied;
    case Fault::kTimeLimit:
      return PathCode::kTimeout;
    case Fault::kWalledIn:
      return PathCode::kNoValidPath;
    default:
      return PathCode::kUnknown;
  }
}

Result<Planner> MakePlanner(const msg::OccupancyGrid& grid, const PlannerConfig& config,
                            const PlannerRobot& robot, const CellMap* keep_out) {
  auto values = ToGrid(grid, config.frame);
  if (!values) return values.error();
  auto map = FromOccupancyGrid(values.value(), {config.blocked_from, config.unknown_is_free});
  if (!map) return map.error();
  if (keep_out != nullptr) BlockKeepOut(*keep_out, map.value());
  return Planner::Make(std::move(map).value(), RulesOf(robot));
}

Result<Planner> MakePlanner(const msg::PointCloud2& cloud, const PlannerConfig& config,
                            const PlannerRobot& robot, const CellMap* keep_out) {
  auto points = ToPoints(cloud, config.frame);
  if (!points) return points.error();
  auto tree = OctreeMap::Make(config.cloud_resolution_m);
  if (!tree) return tree.error();
  tree.value().Block(points.value());
  auto map = tree.value().Cells({true, config.cloud_margin_m});
  if (!map) return map.error();
  auto between = BetweenGroundAndCeiling(map.value(), config.ceiling_m);
  if (!between) return between.error();
  if (keep_out != nullptr) BlockKeepOut(*keep_out, between.value());
  return Planner::Make(std::move(between).value(), RulesOf(robot));
}

Result<Plan> FindRefuge(const Planner& planner, const RefugeRequest& request,
                        const PlannerRobot& robot, const std::function<bool()>& stop) {
  CellMap map = Around(planner.clearance().map(), {request.start}, kAroundRobotM);
  const CellMap place = map;
  BlockPoints(NewlySeen(planner, request.seen, robot.flies), map);
  BlockPoints(BodiesOf(request.others, map), map);
  PlannerRules rules = RulesOf(robot);
  rules.start_within_m += place.resolution_m;  // it stands before the other
  const auto local = Planner::Make(std::move(map), rules, stop);
  if (!local) return local.error();
  struct Kept {
    Clearance away;
    double least_m = 0;
  };
  std::vector<Kept> kept;
  for (const RobotIntent& other : request.others) {
    if (other.path.empty()) continue;
    const double rounding_m = place.resolution_m;
    kept.push_back(
        {AwayFromPath(other, place), KeptApart(robot.radius_m, other.radius_m, {}) + rounding_m});
  }
  const auto is_off = [&](std::size_t cell) {
    return std::ranges::all_of(
        kept, [&](const Kept& one) { return one.away.OfCell(cell) >= one.least_m; });
  };
  return local.value().FindNearest(request.start, is_off, stop);
}

PathReply FindPath(const Planner& planner, const PathRequest& request, const PlannerConfig& config,
                   const PlannerRobot& robot, const std::function<bool()>& stop) {
  if (robot.flies) {
    if (auto checked = CheckAltitude(request.goal, config); !checked) {
      return Refused(checked.error());
    }
  }
  // A search of a few cells does not ask; the request may have waited for a map.
  if (stop && stop()) {
    return Refused(MakeError(Fault::kTimeLimit, "the request reached its time limit"));
  }
  const CellMap& map = planner.clearance().map();
  const std::vector<Point> seen = NewlySeen(planner, request.seen, robot.flies);
  const double keep_m = robot.radius_m + robot.margin_m;
  if (auto rest = RestOf(request, planner.clearance(), keep_m)) {
    if (IsClear(rest->path, seen, keep_m)) return {std::move(*rest), PathCode::kNone, false};
    auto local = FindLocally(planner, request, *rest, seen, robot, stop);
    if (local) return {std::move(*local), PathCode::kNone, true};
  }
  auto plan = planner.Find(request.start, request.goal, stop);
  if (!plan.ok()) {
    if (!Is(plan.error(), Fault::kOutside)) return Refused(plan.error());
    const bool goal = !map.Has(map.CellOf(request.goal.at));
    return Refused(goal ? MakeError(Fault::kGoalOutside, plan.error().message) : plan.error());
  }
  if (IsClear(plan.value().path, seen, keep_m)) return {std::move(plan), PathCode::kNone, false};
  auto around = FindAround(planner, request, plan.value(), seen, robot, stop);
  const auto find_around_part = [&](const std::function<bool(double)>& counts) {
    std::vector<Point> part = seen;
    std::erase_if(part, [&](const Point& point) {
      const Point& start = request.start.at;
      return !counts(std::hypot(point.x_m - start.x_m, point.y_m - start.y_m));
    });
    if (around || part.size() == seen.size() || IsClear(plan.value().path, part, keep_m)) return;
    around = FindAround(planner, request, plan.value(), part, robot, stop);
  };
  // What the robot stands beside, such as a person right behind it, leaves no room to start; its
  // gate lets it go away from that.
  const double beside_m = keep_m + 2 * map.resolution_m;
  find_around_part([&](double away_m) { return away_m > beside_m; });
  // What closes the way farther off may have gone before the robot is there.
  find_around_part([](double away_m) { return away_m <= kNearM; });
  if (!around) return {std::move(plan), PathCode::kNone, false};
  return {std::move(*around), PathCode::kNone, true};
}

}  // namespace musher::navigation
