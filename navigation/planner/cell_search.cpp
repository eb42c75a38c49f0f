#include "musher/navigation/planner/cell_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

namespace musher::navigation {
namespace {

constexpr std::uint32_t kNotLabelled = 0xffffffff;
constexpr std::size_t kCellsBetweenStops = 1024;

struct Neighbour {
  Cell by;
  float length = 0;  // in cells
};

std::vector<Neighbour> Neighbours(bool flat) {
  std::vector<Neighbour> neighbours;
  for (int z = flat ? 0 : -1; z <= (flat ? 0 : 1); ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        if (x == 0 && y == 0 && z == 0) continue;
        neighbours.push_back({{x, y, z}, std::sqrt(static_cast<float>(x * x + y * y + z * z))});
      }
    }
  }
  return neighbours;
}

Cell Moved(const Cell& cell, const Cell& by) {
  return {cell.x + by.x, cell.y + by.y, cell.z + by.z};
}

// The length of the shortest path without anything in it, in cells.
float LeastLength(const Cell& from, const Cell& to) {
  std::array<int, 3> away = {std::abs(from.x - to.x), std::abs(from.y - to.y),
                             std::abs(from.z - to.z)};
  std::sort(away.begin(), away.end());
  constexpr float kRoot2 = 1.41421356F, kRoot3 = 1.7320508F;
  return static_cast<float>(away[0]) * (kRoot3 - kRoot2) +
         static_cast<float>(away[1]) * (kRoot2 - 1) + static_cast<float>(away[2]);
}

struct Open {
  float total = 0;  // the length so far and the least length of the rest
  float rest = 0;
  std::uint32_t cell = 0;

  bool operator<(const Open& other) const {
    if (total != other.total) return total > other.total;
    if (rest != other.rest) return rest > other.rest;
    return cell > other.cell;
  }
};

}  // namespace

CellSearch::CellSearch(std::shared_ptr<const Clearance> clearance, double radius_m,
                       const std::function<bool()>& stop)
    : clearance_(std::move(clearance)),
      map_(clearance_->map()),
      radius_m_(radius_m),
      region_(map_.count()),
      roomy_(map_.count()) {
  complete_ = FindOpenCells(stop) && LabelRegions(stop);
}

// False: stopped.
bool CellSearch::FindOpenCells(const std::function<bool()>& stop) {
  // Half-way between two neighbours the corner of a cell is nearer than at both ends.
  const double half_step_m = map_.resolution_m * (map_.flat() ? M_SQRT1_2 : std::sqrt(0.75));
  const double roomy_m = std::hypot(radius_m_, half_step_m);
  for (std::size_t i = 0; i < map_.count(); ++i) {
    if (i % kCellsBetweenStops == 0 && stop && stop()) return false;
    // From centre to centre; the blocked cell itself is nearer by half a cell to half its diagonal.
    const double near_m = clearance_->OfCell(i);
    roomy_[i] = near_m - half_step_m >= roomy_m;
    const bool open = roomy_[i] || clearance_->Fits(map_.CentreOf(map_.CellAt(i)), radius_m_);
    region_[i] = open ? kNotLabelled : 0;
  }
  return true;
}

bool CellSearch::Passes(std::size_t from, std::size_t to) const {
  if (roomy_[from] && roomy_[to]) return true;
  return clearance_->FitsAlong(map_.CentreOf(map_.CellAt(from)), map_.CentreOf(map_.CellAt(to)),
                               radius_m_);
}

// False: stopped.
bool CellSearch::LabelRegions(const std::function<bool()>& stop) {
  const auto neighbours = Neighbours(map_.flat());
  sizes_ = {0};
  std::vector<std::uint32_t> to_visit;
  std::size_t visited = 0;
  for (std::size_t first = 0; first < region_.size(); ++first) {
    if (region_[first] != kNotLabelled) continue;
    const auto label = static_cast<std::uint32_t>(sizes_.size());
    sizes_.push_back(0);
    region_[first] = label;
    to_visit.push_back(static_cast<std::uint32_t>(first));
    while (!to_visit.empty()) {
      if (++visited % kCellsBetweenStops == 0 && stop && stop()) return false;
      const Cell cell = map_.CellAt(to_visit.back());
      to_visit.pop_back();
      ++sizes_.back();
      for (const Neighbour& neighbour : neighbours) {
        const Cell next = Moved(cell, neighbour.by);
        if (!map_.Has(next)) continue;
        const std::size_t index = map_.IndexOf(next);
        if (region_[index] != kNotLabelled || !Passes(map_.IndexOf(cell), index)) continue;
        region_[index] = label;
        to_visit.push_back(static_cast<std::uint32_t>(index));
      }
    }
  }
  return true;
}

double CellSearch::SizeOf(std::uint32_t region) const {
  return static_cast<double>(sizes_[region]) * std::pow(map_.resolution_m, map_.flat() ? 2 : 3);
}

std::vector<Cell> CellSearch::EntriesOf(const Point& place, double reach_m, double radius_m) const {
  const int reach = static_cast<int>(std::ceil(std::min(reach_m / map_.resolution_m, 50.0)));
  const int reach_z = map_.flat() ? 0 : reach;
  const Cell middle = map_.CellOf(place);
  std::vector<std::pair<double, Cell>> entries;
  for (int z = -reach_z; z <= reach_z; ++z) {
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        const Cell cell = Moved(middle, {x, y, z});
        if (!IsOpen(cell)) continue;
        Point centre = map_.CentreOf(cell);
        if (map_.flat()) centre.z_m = place.z_m;
        if (!clearance_->FitsAlong(place, centre, radius_m)) continue;
        entries.emplace_back(Distance(place, centre), cell);
      }
    }
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Cell> cells;
  cells.reserve(entries.size());
  for (const auto& entry : entries) cells.push_back(entry.second);
  return cells;
}

std::optional<CellSearch::Path> CellSearch::Search(const Cell& from, const Cell& to,
                                                   const std::function<bool()>& stop) const {
  const std::size_t last = map_.IndexOf(to);
  return Expand(
      from, [last](std::size_t at) { return at == last; },
      [&to](const Cell& cell) { return LeastLength(cell, to); }, stop);
}

std::optional<CellSearch::Path> CellSearch::Nearest(const Cell& from,
                                                    const std::function<bool(std::size_t)>& wanted,
                                                    const std::function<bool()>& stop) const {
  return Expand(
      from, wanted, [](const Cell& /*cell*/) { return 0.0F; }, stop);
}

template <class IsEnd, class Rest>
std::optional<CellSearch::Path> CellSearch::Expand(const Cell& from, IsEnd is_end, Rest rest_of,
                                                   const std::function<bool()>& stop) const {
  const auto neighbours = Neighbours(map_.flat());
  constexpr std::uint8_t kFirst = 0xff;
  std::vector<float> length(map_.count(), std::numeric_limits<float>::infinity());
  std::vector<std::uint8_t> came_by(map_.count(), kFirst);
  std::vector<bool> closed(map_.count());
  std::priority_queue<Open> open;
  const auto index = [&](const Cell& cell) {
    return static_cast<std::uint32_t>(map_.IndexOf(cell));
  };
  std::optional<std::uint32_t> last;
  length[index(from)] = 0;
  open.push({rest_of(from), rest_of(from), index(from)});
  for (int visits = 1; !open.empty(); ++visits) {
    if (visits % 1024 == 0 && stop && stop()) return std::nullopt;
    const std::uint32_t at = open.top().cell;
    open.pop();
    if (closed[at]) continue;
    closed[at] = true;
    if (is_end(at)) {
      last = at;
      break;
    }
    const Cell cell = map_.CellAt(at);
    for (std::size_t i = 0; i < neighbours.size(); ++i) {
      const Cell next = Moved(cell, neighbours[i].by);
      if (!IsOpen(next)) continue;
      const std::uint32_t next_index = index(next);
      const float so_far = length[at] + neighbours[i].length;
      if (closed[next_index] || so_far >= length[next_index]) continue;
      if (!Passes(at, next_index)) continue;
      length[next_index] = so_far;
      came_by[next_index] = static_cast<std::uint8_t>(i);
      const float rest = rest_of(next);
      open.push({so_far + rest, rest, next_index});
    }
  }
  if (!last) return std::nullopt;
  Path path;
  path.length_m = length[*last] * map_.resolution_m;
  for (Cell cell = map_.CellAt(*last);;) {
    path.cells.push_back(cell);
    const std::uint8_t by = came_by[index(cell)];
    if (by == kFirst) break;
    const Cell& step = neighbours[by].by;
    cell = Moved(cell, {-step.x, -step.y, -step.z});
  }
  std::reverse(path.cells.begin(), path.cells.end());
  return path;
}

}  // namespace musher::navigation
