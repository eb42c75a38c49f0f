#include "musher/modules/skills/coverage/cells.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace musher::coverage {
namespace {

// A cell while the space is swept upwards.
struct GrowingCell {
  std::vector<Lane> slices;
  // What has to be covered beyond the slices: the radius before a wall. The narrow cell beside a
  // wide one begins where the wide one has covered up to its wall.
  double below_m = 0;
  double above_m = 0;
};

bool Overlap(const Interval& a, const Interval& b) {
  return a.begin_m < b.end_m && b.begin_m < a.end_m;
}

double Width(const Interval& interval) {
  return interval.end_m - interval.begin_m;
}

double Change(const Interval& a, const Interval& b) {
  return std::max(std::abs(a.begin_m - b.begin_m), std::abs(a.end_m - b.end_m));
}

// Sweeps over the slices; `open` are the cells of the last one.
class Sweep {
 public:
  Sweep(const FreeSpace& space, double jump_m) : space_(space), jump_m_(jump_m) {}

  void Add(double y_m, const std::vector<Interval>& free) {
    std::vector<std::size_t> next;
    for (const Interval& interval : free) {
      std::vector<std::size_t> below;
      for (const std::size_t cell : open_) {
        if (Overlap(Last(cell).x, interval)) below.push_back(cell);
      }
      const bool continues = below.size() == 1 && Above(below[0], free) == 1 &&
                             !Jumps(Last(below[0]), {y_m, interval});
      next.push_back(continues ? below[0] : Begin(interval, below));
    }
    for (std::size_t i = 0; i < free.size(); ++i) cells_[next[i]].slices.push_back({y_m, free[i]});
    open_ = next;
  }
  std::vector<GrowingCell> Take() { return std::move(cells_); }

 private:
  const Lane& Last(std::size_t cell) const { return cells_[cell].slices.back(); }

  std::size_t Begin(const Interval& interval, const std::vector<std::size_t>& below) {
    const double radius_m = space_.radius_m();
    bool narrow = !below.empty();
    for (const std::size_t cell : below) {
      const bool wider = Width(interval) > Width(Last(cell).x);
      cells_[cell].above_m = wider ? -radius_m : radius_m;
      narrow = narrow && !wider;
    }
    cells_.push_back({{}, narrow ? -radius_m : radius_m, radius_m});
    return cells_.size() - 1;
  }
  // How many free intervals continue the cell.
  std::ptrdiff_t Above(std::size_t cell, const std::vector<Interval>& free) const {
    return std::ranges::count_if(
        free, [&](const Interval& interval) { return Overlap(Last(cell).x, interval); });
  }
  // Whether the free interval changes at one place between the two: a corner, not a slope.
  bool Jumps(Lane low, Lane high) const {
    constexpr int kHalvings = 12;
    for (int i = 0; i < kHalvings; ++i) {
      if (Change(low.x, high.x) < jump_m_) return false;
      const double y_m = (low.y_m + high.y_m) / 2;
      const std::vector<Interval> free = space_.At(y_m);
      const auto middle = std::ranges::find_if(free, [&](const Interval& interval) {
        return Overlap(low.x, interval) && Overlap(interval, high.x);
      });
      if (middle == free.end()) return true;
      const Lane lane{y_m, *middle};
      (Change(low.x, *middle) > Change(*middle, high.x) ? high : low) = lane;
    }
    return true;
  }

  const FreeSpace& space_;
  const double jump_m_;
  std::vector<GrowingCell> cells_;
  std::vector<std::size_t> open_;
};

Cell WithLanes(const GrowingCell& growing, double lane_width_m) {
  const std::vector<Lane>& slices = growing.slices;
  const double low = slices.front().y_m - growing.below_m;
  const double high = slices.back().y_m + growing.above_m;
  constexpr double kEnough = 0.02;  // of a lane: what remains uncovered
  // More than two for each slice would only be the same slices again.
  const double lanes = std::min(std::ceil((high - low) / lane_width_m - kEnough),
                                2.0 * static_cast<double>(slices.size()));
  Cell cell;
  std::size_t last = slices.size();
  for (int i = 0; i < static_cast<int>(lanes); ++i) {
    const double y = low + (high - low) * (i + 0.5) / lanes;
    const auto above = std::ranges::lower_bound(slices, y, {}, &Lane::y_m);
    auto index = static_cast<std::size_t>(above - slices.begin());
    if (index == slices.size()) index = slices.size() - 1;
    if (index > 0 && y - slices[index - 1].y_m < slices[index].y_m - y) --index;
    if (index == last) continue;
    last = index;
    cell.lanes.push_back(slices[index]);
  }
  return cell;
}

}  // namespace

std::vector<Cell> CellsOf(const FreeSpace& space, double lane_width_m, double slice_m) {
  constexpr double kInsideM = 1e-5;
  const double low = space.lowest_m() + space.radius_m() + kInsideM;
  const double high = space.highest_m() - space.radius_m() - kInsideM;
  if (high < low) return {};
  const auto count = static_cast<std::size_t>(std::ceil((high - low) / slice_m)) + 1;
  Sweep sweep(space, lane_width_m / 2);
  for (std::size_t i = 0; i < count; ++i) {
    const double share = count == 1 ? 0.5 : static_cast<double>(i) / static_cast<double>(count - 1);
    const double y = low + share * (high - low);
    sweep.Add(y, space.At(y));
  }
  std::vector<Cell> cells;
  for (const GrowingCell& growing : sweep.Take()) {
    Cell cell = WithLanes(growing, lane_width_m);
    if (!cell.lanes.empty()) cells.push_back(std::move(cell));
  }
  return cells;
}

}  // namespace musher::coverage
