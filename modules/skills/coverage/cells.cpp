#include "musher/modules/skills/coverage/cells.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
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

// What lanes leave of a cell: of lines at the heights that its lanes are to cover, each a little
// longer than the free interval, the parts that are farther than half a lane from every lane.
class Uncovered {
 public:
  Uncovered(const GrowingCell& cell, double lane_width_m) : reach_m_(lane_width_m / 2) {
    constexpr int kLines = 60;
    constexpr double kBeyond = 0.7;  // of the reach: about the half of a disc that is cut off
    const std::vector<Lane>& slices = cell.slices;
    const double low_m = slices.front().y_m - cell.below_m;
    const double high_m = slices.back().y_m + cell.above_m;
    for (int i = 0; i < kLines; ++i) {
      const double y_m = low_m + (high_m - low_m) * (i + 0.5) / kLines;
      const auto above = std::ranges::lower_bound(slices, y_m, {}, &Lane::y_m);
      const Interval& x = (above == slices.end() ? slices.back() : *above).x;
      const Interval line{x.begin_m - kBeyond * reach_m_, x.end_m + kBeyond * reach_m_};
      lines_.push_back({y_m, {line}});
      left_m_ += Width(line);
    }
    all_m_ = left_m_;
  }

  double share() const { return all_m_ > 0 ? left_m_ / all_m_ : 0; }
  // The share that another lane would cover.
  double GainOf(const Lane& lane) const {
    double gain_m = 0;
    for (const Line& line : lines_) {
      const Interval taken = TakenOf(lane, line.y_m);
      for (const Interval& part : line.left) {
        gain_m += std::max(
            std::min(part.end_m, taken.end_m) - std::max(part.begin_m, taken.begin_m), 0.0);
      }
    }
    return all_m_ > 0 ? gain_m / all_m_ : 0;
  }
  void Take(const Lane& lane) {
    left_m_ = 0;
    for (Line& line : lines_) {
      const Interval taken = TakenOf(lane, line.y_m);
      std::vector<Interval> left;
      for (const Interval& part : line.left) {
        const Interval before{part.begin_m, std::min(part.end_m, taken.begin_m)};
        const Interval after{std::max(part.begin_m, taken.end_m), part.end_m};
        if (taken.begin_m >= taken.end_m) {
          left.push_back(part);
          continue;
        }
        if (before.begin_m < before.end_m) left.push_back(before);
        if (after.begin_m < after.end_m) left.push_back(after);
      }
      line.left = std::move(left);
      for (const Interval& part : line.left) left_m_ += Width(part);
    }
  }
  // The longest part of a slice that no lane covers yet, as a lane.
  std::optional<Lane> LongestOf(const Lane& slice) const {
    const auto above = std::ranges::lower_bound(lines_, slice.y_m, {}, &Line::y_m);
    const Line& line = above == lines_.end() ? lines_.back() : *above;
    std::optional<Lane> longest;
    for (const Interval& part : line.left) {
      const Lane lane{
          slice.y_m,
          {std::max(part.begin_m, slice.x.begin_m), std::min(part.end_m, slice.x.end_m)}};
      // Else it is beyond the end of the slice: its very end is what comes nearest.
      if (lane.x.begin_m >= lane.x.end_m) continue;
      if (!longest || Width(lane.x) > Width(longest->x)) longest = lane;
    }
    return longest;
  }

 private:
  struct Line {
    double y_m = 0;
    std::vector<Interval> left;
  };

  // Of a line at that height.
  Interval TakenOf(const Lane& lane, double y_m) const {
    const double away_m = std::abs(lane.y_m - y_m);
    if (away_m >= reach_m_) return {};
    const double beyond_m = std::sqrt(reach_m_ * reach_m_ - away_m * away_m);
    return {lane.x.begin_m - beyond_m, lane.x.end_m + beyond_m};
  }

  const double reach_m_;
  double all_m_ = 0;
  double left_m_ = 0;
  std::vector<Line> lines_;
};

// Between walls that come together the lanes in the middle of their strips leave the wide ends: for
// those there are more lanes, the one that covers most first.
void AddLanes(const GrowingCell& growing, double lane_width_m, std::vector<Lane>& lanes) {
  constexpr double kEnough = 0.03;  // of the cell: what remains uncovered
  constexpr double kLeast = 0.015;  // what another lane has to cover
  constexpr std::size_t kMostTried = 40;
  constexpr std::size_t kMostAdded = 6;
  Uncovered uncovered(growing, lane_width_m);
  for (const Lane& lane : lanes) uncovered.Take(lane);
  const std::vector<Lane>& slices = growing.slices;
  const std::size_t every = slices.size() / kMostTried + 1;
  for (std::size_t added = 0; added < kMostAdded && uncovered.share() > kEnough; ++added) {
    std::optional<Lane> best;
    double most = kLeast;
    for (std::size_t i = 0; i < slices.size(); i += every) {
      const auto part = uncovered.LongestOf(slices[i]);
      const double gain = part ? uncovered.GainOf(*part) : 0;
      if (gain <= most) continue;
      most = gain;
      best = part;
    }
    if (!best) break;
    lanes.push_back(*best);
    uncovered.Take(*best);
  }
  std::ranges::stable_sort(lanes, [](const Lane& a, const Lane& b) {
    return a.y_m != b.y_m ? a.y_m < b.y_m : a.x.begin_m < b.x.begin_m;
  });
}

Cell WithLanes(const GrowingCell& growing, double lane_width_m, bool whole) {
  const std::vector<Lane>& slices = growing.slices;
  const double low = slices.front().y_m - growing.below_m;
  const double high = slices.back().y_m + growing.above_m;
  constexpr double kEnough = 0.02;  // of a lane: what remains uncovered
  // A lane beside another one that is nearer than this covers hardly more: the strip of a lane is
  // some centimetres wider than the robot, and has it only once.
  const double apart_m = lane_width_m / 4;
  const double span_m = slices.back().y_m - slices.front().y_m;
  // More than two for each slice would only be the same slices again.
  const double lanes =
      std::min({std::ceil((high - low) / lane_width_m - kEnough),
                2.0 * static_cast<double>(slices.size()), 1 + std::floor(span_m / apart_m)});
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
  constexpr std::size_t kFewLanes = 4;  // in more than these the ends are little of the cell
  if (whole && !cell.lanes.empty() && cell.lanes.size() <= kFewLanes) {
    AddLanes(growing, lane_width_m, cell.lanes);
  }
  return cell;
}

}  // namespace

std::vector<Cell> CellsOf(const FreeSpace& space, double lane_width_m, double slice_m, bool whole) {
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
    Cell cell = WithLanes(growing, lane_width_m, whole);
    if (!cell.lanes.empty()) cells.push_back(std::move(cell));
  }
  return cells;
}

}  // namespace musher::coverage
