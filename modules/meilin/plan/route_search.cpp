#include "musher/modules/meilin/plan/route_search.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace musher::meilin {
namespace {

constexpr std::array<Direction, 3> kAhead = {Direction::kForward, Direction::kLeft,
                                             Direction::kRight};

std::size_t BitOf(Cell cell) {
  return std::size_t{1} << static_cast<unsigned>(cell.row * kCols + cell.col);
}

auto RankOf(const Route& route) {
  return std::tuple(route.cost_s, route.kfs1_affected, route.steps.size());
}

class RouteSearch {
 public:
  RouteSearch(const BoxMap& map, const RouteRules& rules) : map_(map), rules_(rules) {
    rules_.plan.grid.side = map.side;
  }

  RouteReport Run() {
    for (int col = 0; col < kCols; ++col) {
      const Cell start{0, col};
      if (IsOpen(start)) Enter(start, {.cost_s = rules_.costs.Move(0, 0)});
    }
    return std::move(report_);
  }

 private:
  struct State {
    Cell cell{};
    double yaw_rad = 0;
    bool at_centre = true;
    std::size_t visited = 0;  // bits of cells
    std::size_t taken = 0;
    int kfs2 = 0;
    int kfs1 = 0;
    double cost_s = 0;
  };

  int Height(Cell cell) const { return rules_.plan.grid.HeightMm(cell); }
  bool IsFree(Cell cell, std::size_t taken = 0) const {
    if (!IsInside(cell) || map_.At(cell) == Box::kFake) return false;
    if (map_.At(cell) == Box::kKfs1 && rules_.plan.kfs1_blocks) return false;
    return map_.At(cell) != Box::kKfs2 || (taken & BitOf(cell)) != 0;
  }
  // The straight way there from the entrance: row 0 is flat.
  bool IsOpen(Cell start) const {
    const Grid& grid = rules_.plan.grid;
    const Cell entrance = rules_.entrance;
    return IsFree(start) &&
           std::ranges::all_of(grid.CellsOnLine(grid.Centre(entrance), grid.Centre(start)),
                               [&](Cell cell) { return cell == entrance || IsFree(cell); });
  }
  double MoveYaw(const State& state) const { return map_.omni ? 0 : state.yaw_rad; }

  // Moves to `cell`, whose cost `state` already has.
  void Enter(Cell cell, State state) {
    state.yaw_rad = MoveYaw(state);
    state.cell = cell;
    state.at_centre = true;
    state.visited |= BitOf(cell);
    if (map_.At(cell) == Box::kKfs1) ++state.kfs1;
    steps_.push_back({false, cell, static_cast<double>(Height(cell)), state.yaw_rad});
    Continue(state);
    steps_.pop_back();
  }

  void Continue(const State& state) {
    if (state.cell.row == kRows - 1) return Record(state);
    if (++visits_ > rules_.most_visits) report_.complete = false;
    if (!report_.complete) return;
    if (state.kfs2 < kMostFetched) {
      for (const Direction direction : kAhead) TryFetch(state, direction);
    }
    for (const Direction direction : kAhead) {
      const Cell to = Next(state.cell, direction);
      if (!IsFree(to, state.taken) || (state.visited & BitOf(to)) != 0) continue;
      State next = state;
      next.cost_s += rules_.costs.Move(Height(state.cell), Height(to));
      Enter(to, next);
    }
  }

  void TryFetch(const State& state, Direction direction) {
    const Cell box = Next(state.cell, direction);
    if (!IsInside(box) || map_.At(box) != Box::kKfs2 || (state.taken & BitOf(box)) != 0) return;
    const int difference_mm = Height(box) - Height(state.cell);
    if (!Reaches(difference_mm)) return;
    State next = state;
    const std::size_t steps = steps_.size();
    if (!state.at_centre) {
      next.yaw_rad = MoveYaw(state);
      next.cost_s += rules_.costs.Move(0, 0);
      steps_.push_back({false, state.cell, static_cast<double>(Height(state.cell)), next.yaw_rad});
    }
    const double yaw_rad = YawOf(direction);
    next.cost_s +=
        rules_.costs.Fetch(YawDistance(next.yaw_rad, yaw_rad) > rules_.plan.yaw_tolerance_rad);
    next.yaw_rad = yaw_rad;
    next.at_centre = false;
    next.taken |= BitOf(box);
    ++next.kfs2;
    steps_.push_back({true, box, static_cast<double>(difference_mm), yaw_rad});
    Continue(next);
    steps_.resize(steps);
  }

  bool Reaches(int difference_mm) const {
    if (std::abs(difference_mm) <= rules_.plan.height_tolerance_mm) return true;
    const double wheels_mm = rules_.plan.normal_height_mm + difference_mm;
    return wheels_mm >= 0 && wheels_mm <= rules_.plan.highest_wheel_mm;
  }

  void Record(const State& state) {
    RouteBucket& bucket = report_.routes.at(static_cast<std::size_t>(state.kfs2));
    ++bucket.total;
    auto& routes = bucket.routes;
    const std::tuple rank(state.cost_s, state.kfs1, steps_.size());
    if (routes.size() >= rules_.most_routes && (routes.empty() || rank >= RankOf(routes.back()))) {
      return;
    }
    // Behind those of the same rank, which were found earlier.
    const auto at = std::find_if(routes.begin(), routes.end(),
                                 [&](const Route& route) { return rank < RankOf(route); });
    routes.insert(at, {steps_, state.cost_s, state.kfs2, state.kfs1});
    if (routes.size() > rules_.most_routes) routes.pop_back();
  }

  const BoxMap& map_;
  RouteRules rules_;
  std::vector<PlanStep> steps_;  // of the plan that is being built
  std::uint64_t visits_ = 0;
  RouteReport report_;
};

}  // namespace

RouteReport FindRoutes(const BoxMap& map, const RouteRules& rules) {
  return RouteSearch(map, rules).Run();
}

const Route* BestRoute(const Routes& routes) {
  for (const std::size_t count : {2, 3, 4, 1, 0}) {
    if (!routes.at(count).routes.empty()) return &routes.at(count).routes.front();
  }
  return nullptr;
}

}  // namespace musher::meilin
