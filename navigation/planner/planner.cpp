#include "musher/navigation/planner/planner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "musher/navigation/place_text.hpp"

namespace musher::navigation {
namespace {

std::string SizeText(double size, bool flat) {
  return fmt::format("{:.2f} {}", size, flat ? "m²" : "m³");
}

double LengthOf(const std::vector<Point>& points) {
  double length_m = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length_m += Distance(points[i - 1], points[i]);
  return length_m;
}

struct Connection {
  Cell from;
  Cell to;
};

// The nearest entries that lie in one region.
std::optional<Connection> ConnectionOf(const CellSearch& search, const std::vector<Cell>& starts,
                                       const std::vector<Cell>& goals) {
  for (const Cell& start : starts) {
    for (const Cell& goal : goals) {
      if (search.RegionOf(start) == search.RegionOf(goal)) return Connection{start, goal};
    }
  }
  return std::nullopt;
}

Result<> CheckRules(const PlannerRules& rules) {
  const auto bad = [](double value) { return !std::isfinite(value) || value < 0; };
  if (bad(rules.radius_m) || bad(rules.comfort_m) || bad(rules.start_within_m)) {
    return MakeError(Fault::kInput,
                     fmt::format("planner: radius {} m, comfort {} m, start within {} m; expected "
                                 "numbers from 0 on",
                                 rules.radius_m, rules.comfort_m, rules.start_within_m));
  }
  return Ok();
}

}  // namespace

struct Planner::Ends {
  Connection tight;
  std::optional<Connection> comfortable;
};

Planner::Planner(CellMap map, const PlannerRules& rules, const std::function<bool()>& stop)
    : rules_(rules), clearance_(std::make_shared<Clearance>(std::move(map), stop)) {
  if (!clearance_->complete()) return;
  search_ = std::make_shared<CellSearch>(clearance_, rules.radius_m, stop);
  if (rules.comfort_m <= 0 || !search_->complete()) return;
  comfortable_ = std::make_shared<CellSearch>(clearance_, rules.radius_m + rules.comfort_m, stop);
}

bool Planner::complete() const {
  return search_ && search_->complete() && (!comfortable_ || comfortable_->complete());
}

Result<Planner> Planner::Make(CellMap map, const PlannerRules& rules,
                              const std::function<bool()>& stop) {
  auto checked = CheckCellMap(map);
  if (checked.ok()) checked = CheckRules(rules);
  if (!checked.ok()) return checked.error();
  Planner planner(std::move(map), rules, stop);
  if (planner.complete()) return planner;
  return MakeError(Fault::kTimeLimit, "the distances of the map reached their time limit");
}

Result<> Planner::CheckEnd(const std::string& name, const Pose& pose, double radius_m,
                           Fault blocked) const {
  const CellMap& map = clearance_->map();
  if (!IsFinite(pose)) {
    return MakeError(Fault::kInput, fmt::format("{}: it has a number that is not finite", name));
  }
  const std::string place = PlaceText(pose.at, map.flat());
  if (!map.Has(map.CellOf(pose.at))) {
    return MakeError(Fault::kOutside,
                     fmt::format("{} {} is outside the map ({})", name, place, map.ExtentText()));
  }
  if (clearance_->Fits(pose.at, radius_m)) return Ok();
  const double room_m = clearance_->At(pose.at, radius_m);
  if (room_m == 0) return MakeError(blocked, fmt::format("{} {} is in an obstacle", name, place));
  return MakeError(blocked,
                   fmt::format("{} {} is {:.2f} m from an obstacle, the body needs {:.2f} m", name,
                               place, room_m, radius_m));
}

Result<> Planner::CheckStart(const Pose& start) const {
  return CheckEnd("start", start, std::max(0.0, rules_.radius_m - rules_.start_within_m),
                  Fault::kStartBlocked);
}

Result<Planner::Ends> Planner::Connect(const Point& start, const Point& goal) const {
  const bool flat = clearance_->map().flat();
  const double resolution_m = clearance_->map().resolution_m;
  // A body that stands too close keeps what room it has until it is free.
  const double start_radius_m =
      std::min(rules_.radius_m, clearance_->At(start, rules_.radius_m)) * (1 - 1e-9);
  const double reach_m = 2 * resolution_m;
  const auto starts = search_->EntriesOf(start, reach_m + rules_.start_within_m, start_radius_m);
  const auto goals = search_->EntriesOf(goal, reach_m, rules_.radius_m);
  for (const auto& [entries, name, place, fault] :
       {std::tuple{&starts, "start", start, Fault::kStartBlocked},
        std::tuple{&goals, "goal", goal, Fault::kGoalBlocked}}) {
    if (!entries->empty()) continue;
    return MakeError(fault, fmt::format("{} {} has no room around it to move a body of {:.2f} m "
                                        "radius",
                                        name, PlaceText(place, flat), rules_.radius_m));
  }
  const auto tight = ConnectionOf(*search_, starts, goals);
  if (!tight) {
    const double from_start = search_->SizeOf(search_->RegionOf(starts[0]));
    const double from_goal = search_->SizeOf(search_->RegionOf(goals[0]));
    const bool goal_enclosed = from_goal <= from_start;
    return MakeError(
        Fault::kWalledIn,
        fmt::format("no path for a body of {:.2f} m radius: {} {} is walled in, within {}; {} has "
                    "{}",
                    rules_.radius_m, goal_enclosed ? "goal" : "start",
                    PlaceText(goal_enclosed ? goal : start, flat),
                    SizeText(std::min(from_goal, from_start), flat),
                    goal_enclosed ? "start" : "goal",
                    SizeText(std::max(from_goal, from_start), flat)));
  }
  Ends ends{*tight, std::nullopt};
  if (comfortable_) {
    const double more_m = reach_m + 2 * rules_.comfort_m;
    ends.comfortable =
        ConnectionOf(*comfortable_,
                     comfortable_->EntriesOf(start, more_m + rules_.start_within_m, start_radius_m),
                     comfortable_->EntriesOf(goal, more_m, rules_.radius_m));
  }
  return ends;
}

std::vector<Point> Planner::Shortened(const std::vector<Cell>& cells, const Point& start,
                                      const Point& goal, double radius_m) const {
  const CellMap& map = clearance_->map();
  std::vector<Point> points = {start};
  for (const Cell& cell : cells) {
    points.push_back(map.CentreOf(cell));
    if (map.flat()) points.back().z_m = start.z_m;
  }
  points.push_back(goal);
  SmoothingRules rules = rules_.smoothing;
  rules.spline_steps = 0;
  points = Smoothed(points, *clearance_, radius_m, rules);
  rules = rules_.smoothing;
  rules.shortcuts = 0;
  return Smoothed(points, *clearance_, rules_.radius_m, rules);
}

Result<Plan> Planner::FindNearest(const Pose& start,
                                  const std::function<bool(std::size_t cell)>& wanted,
                                  const std::function<bool()>& stop) const {
  auto checked = CheckStart(start);
  if (!checked.ok()) return checked.error();
  const CellMap& map = clearance_->map();
  const Point from = map.flat() ? Point{start.at.x_m, start.at.y_m, 0} : start.at;
  const double room_m =
      std::min(rules_.radius_m, clearance_->At(from, rules_.radius_m)) * (1 - 1e-9);
  const auto entries =
      search_->EntriesOf(from, 2 * map.resolution_m + rules_.start_within_m, room_m);
  std::set<std::uint32_t> regions;
  for (const Cell& entry : entries) {
    if (!regions.insert(search_->RegionOf(entry)).second) continue;
    const auto found = search_->Nearest(entry, wanted, stop);
    if (!found) continue;
    Pose goal{map.CentreOf(found->cells.back()), start.yaw_rad};
    if (map.flat()) goal.at.z_m = start.at.z_m;
    auto plan = Find(start, goal, stop);
    if (!plan || plan.value().path.size() < 2) return plan;
    Path& path = plan.value().path;
    const Point &last = path[path.size() - 2].at, &end = path.back().at;
    if (Distance(last, end) > 0) {
      path.back().yaw_rad = std::atan2(end.y_m - last.y_m, end.x_m - last.x_m);
    }
    return plan;
  }
  return MakeError(Fault::kWalledIn,
                   fmt::format("{} has no such place around it", PlaceText(from, map.flat())));
}

Result<Plan> Planner::Find(const Pose& start, const Pose& goal,
                           const std::function<bool()>& stop) const {
  auto checked = CheckEnd("goal", goal, rules_.radius_m, Fault::kGoalBlocked);
  if (checked.ok()) checked = CheckStart(start);
  if (!checked.ok()) return checked.error();
  const bool flat = clearance_->map().flat();
  const Point from = flat ? Point{start.at.x_m, start.at.y_m, 0} : start.at;
  const Point to = flat ? Point{goal.at.x_m, goal.at.y_m, 0} : goal.at;
  auto ends = Connect(from, to);
  if (!ends.ok()) return ends.error();
  const auto tight = search_->Search(ends.value().tight.from, ends.value().tight.to, stop);
  const auto& connection = ends.value().comfortable;
  std::optional<CellSearch::Path> comfortable;
  if (tight && connection)
    comfortable = comfortable_->Search(connection->from, connection->to, stop);
  if (!tight || (connection && !comfortable)) {
    return MakeError(Fault::kTimeLimit,
                     fmt::format("the search from {} to {} reached its time limit",
                                 PlaceText(from, flat), PlaceText(to, flat)));
  }
  const bool use_comfortable =
      comfortable &&
      comfortable->length_m <= rules_.detour * tight->length_m + 2 * rules_.comfort_m;
  std::vector<Point> points =
      use_comfortable ? Shortened(comfortable->cells, from, to, rules_.radius_m + rules_.comfort_m)
                      : Shortened(tight->cells, from, to, rules_.radius_m);
  Plan plan;
  plan.length_m = LengthOf(points);
  plan.cell_length_m = tight->length_m;
  if (flat) {
    for (Point& point : points) point.z_m = start.at.z_m;
  }
  plan.path = WithHeadings(points, start.yaw_rad, goal.yaw_rad, rules_.heading);
  return plan;
}

}  // namespace musher::navigation
