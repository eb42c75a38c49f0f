#include "musher/modules/skills/coverage/tour.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace musher::coverage {
namespace {

constexpr double kNoWay = std::numeric_limits<double>::infinity();
constexpr std::size_t kEntries = 4;  // lowest or highest lane, from the left or from the right

GroundPoint EndOf(const Lane& lane, bool right) {
  return {right ? lane.x.end_m : lane.x.begin_m, lane.y_m};
}

// One path through a cell: lane after lane, each from one of its ends to the other.
struct Passage {
  std::vector<GroundPoint> ends;  // two a lane
  double between_m = 0;           // from lane to lane
};

// The shortest one that begins so. The side changes from lane to lane unless the other end of the
// next lane is nearer.
Passage PassageOf(const Cell& cell, bool from_top, bool from_right) {
  std::vector<Lane> lanes = cell.lanes;
  if (from_top) std::ranges::reverse(lanes);
  const std::size_t count = lanes.size();
  // By lane and the side on which it begins: the least path to the end of the cell, and the side on
  // which the next one begins.
  std::vector<std::array<double, 2>> left_m(count, {0, 0});
  std::vector<std::array<bool, 2>> next(count, {false, false});
  for (std::size_t i = count - 1; i-- > 0;) {
    for (const bool right : {false, true}) {
      double best = kNoWay;
      for (const bool next_right : {false, true}) {
        const double way = Distance(EndOf(lanes[i], !right), EndOf(lanes[i + 1], next_right)) +
                           left_m[i + 1][next_right ? 1 : 0];
        if (way >= best) continue;
        best = way;
        next[i][right ? 1 : 0] = next_right;
      }
      left_m[i][right ? 1 : 0] = best;
    }
  }
  Passage passage{{}, left_m[0][from_right ? 1 : 0]};
  bool right = from_right;
  for (std::size_t i = 0; i < count; ++i) {
    passage.ends.push_back(EndOf(lanes[i], right));
    passage.ends.push_back(EndOf(lanes[i], !right));
    right = next[i][right ? 1 : 0];
  }
  return passage;
}

// Chooses the order and the passages.
class Ordering {
 public:
  Ordering(const std::vector<Cell>& cells, const std::optional<GroundPoint>& start, Router& router)
      : start_(start) {
    std::vector<GroundPoint> begins;
    for (const Cell& cell : cells) {
      for (std::size_t entry = 0; entry < kEntries; ++entry) {
        passages_.push_back(PassageOf(cell, entry / 2 == 1, entry % 2 == 1));
        begins.push_back(passages_.back().ends.front());
      }
    }
    for (const Passage& passage : passages_) {
      ways_m_.push_back(router.Lengths(passage.ends.back(), begins));
    }
  }

  const Passage& passage(std::size_t index) const { return passages_[index]; }

  // The cells that are joined, of the largest part.
  std::vector<std::size_t> LargestPart() const {
    std::vector<std::size_t> largest;
    double most_m = -1;
    std::vector<bool> seen(passages_.size() / kEntries, false);
    for (std::size_t first = 0; first < seen.size(); ++first) {
      if (seen[first]) continue;
      std::vector<std::size_t> part;
      for (std::size_t cell = 0; cell < seen.size(); ++cell) {
        if (cell != first && Way(first * kEntries, cell * kEntries) == kNoWay) continue;
        part.push_back(cell);
        seen[cell] = true;
      }
      double length_m = 0;
      for (const std::size_t cell : part) length_m += LengthOf(cell);
      if (length_m <= most_m) continue;
      most_m = length_m;
      largest = part;
    }
    return largest;
  }

  // Passages in their order.
  std::vector<std::size_t> Order(const std::vector<std::size_t>& cells) const {
    constexpr std::size_t kExactly = 8;
    return cells.size() <= kExactly ? Shortest(cells) : Nearest(cells);
  }

 private:
  double Way(std::size_t from, std::size_t to) const { return ways_m_[from][to]; }
  double Begin(std::size_t passage) const {
    return start_ ? Distance(*start_, passages_[passage].ends.front()) : 0;
  }
  double LengthOf(std::size_t cell) const {
    const Passage& passage = passages_[cell * kEntries];
    double length_m = 0;
    for (std::size_t i = 0; i + 1 < passage.ends.size(); i += 2) {
      length_m += Distance(passage.ends[i], passage.ends[i + 1]);
    }
    return length_m;
  }

  std::vector<std::size_t> Nearest(std::vector<std::size_t> cells) const {
    std::vector<std::size_t> order;
    while (!cells.empty()) {
      std::size_t best = cells.front() * kEntries;
      double least = kNoWay;
      for (const std::size_t cell : cells) {
        for (std::size_t passage = cell * kEntries; passage < (cell + 1) * kEntries; ++passage) {
          const double way = (order.empty() ? Begin(passage) : Way(order.back(), passage)) +
                             passages_[passage].between_m;
          if (way >= least) continue;
          least = way;
          best = passage;
        }
      }
      order.push_back(best);
      std::erase(cells, best / kEntries);
    }
    return order;
  }

  // Over all sets of covered cells (Held and Karp).
  std::vector<std::size_t> Shortest(const std::vector<std::size_t>& cells) const {
    const std::size_t count = cells.size(), all = (std::size_t{1} << count) - 1;
    const std::size_t states = count * kEntries;
    const auto passage_of = [&](std::size_t state) {
      return cells[state / kEntries] * kEntries + state % kEntries;
    };
    std::vector<double> least((all + 1) * states, kNoWay);
    std::vector<std::size_t> before((all + 1) * states, states);
    for (std::size_t state = 0; state < states; ++state) {
      const std::size_t passage = passage_of(state);
      least[(std::size_t{1} << (state / kEntries)) * states + state] =
          Begin(passage) + passages_[passage].between_m;
    }
    for (std::size_t set = 1; set <= all; ++set) {
      for (std::size_t last = 0; last < states; ++last) {
        const double so_far = least[set * states + last];
        if (so_far == kNoWay) continue;
        for (std::size_t next = 0; next < states; ++next) {
          const std::size_t bit = std::size_t{1} << (next / kEntries);
          if ((set & bit) != 0) continue;
          const double way = so_far + Way(passage_of(last), passage_of(next)) +
                             passages_[passage_of(next)].between_m;
          double& known = least[(set | bit) * states + next];
          if (way >= known) continue;
          known = way;
          before[(set | bit) * states + next] = last;
        }
      }
    }
    const auto row = least.begin() + static_cast<std::ptrdiff_t>(all * states);
    auto state = static_cast<std::size_t>(std::min_element(row, least.end()) - row);
    std::vector<std::size_t> order;
    for (std::size_t set = all; set != 0;) {
      order.push_back(passage_of(state));
      const std::size_t earlier = before[set * states + state];
      set &= ~(std::size_t{1} << (state / kEntries));
      state = earlier;
    }
    std::ranges::reverse(order);
    return order;
  }

  const std::optional<GroundPoint> start_;
  std::vector<Passage> passages_;  // kEntries a cell
  std::vector<std::vector<double>> ways_m_;
};

void Append(Tour& tour, const GroundPoint& corner, bool on_lane) {
  tour.corners.push_back(corner);
  if (tour.corners.size() > 1) tour.on_lane.push_back(on_lane);
}

// From the last corner, or back along the lane that has led to it, as out of a dead end. Empty:
// there is none.
std::vector<GroundPoint> WayTo(const GroundPoint& to, const Tour& tour, Router& router) {
  const std::vector<GroundPoint>& corners = tour.corners;
  std::vector<GroundPoint> way = router.Route(corners.back(), to);
  if (!way.empty() || corners.size() < 2) return way;
  way = router.Route(corners[corners.size() - 2], to);
  if (!way.empty()) way.insert(way.begin(), corners.back());
  return way;
}

// Adds a lane, from either of its ends; false: there is no way to it that keeps the radius, as
// beside a gap that is just as wide as the robot.
bool AppendLane(Tour& tour, const GroundPoint& from, const GroundPoint& to, Router& router) {
  if (tour.corners.empty()) {
    Append(tour, from, false);
    Append(tour, to, true);
    return true;
  }
  for (const auto& [begin, end] : {std::pair(from, to), std::pair(to, from)}) {
    const std::vector<GroundPoint> way = WayTo(begin, tour, router);
    if (way.empty()) continue;
    for (std::size_t k = 1; k < way.size(); ++k) Append(tour, way[k], false);
    Append(tour, end, true);
    return true;
  }
  return false;
}

}  // namespace

Tour TourOf(const std::vector<Cell>& cells, const std::optional<GroundPoint>& start,
            Router& router) {
  Tour tour;
  if (cells.empty()) return tour;
  const Ordering ordering(cells, start, router);
  const std::vector<std::size_t> part = ordering.LargestPart();
  std::size_t whole = 0;
  for (const std::size_t index : ordering.Order(part)) {
    const std::vector<GroundPoint>& ends = ordering.passage(index).ends;
    bool left_out = false;
    for (std::size_t i = 0; i + 1 < ends.size(); i += 2) {
      if (!AppendLane(tour, ends[i], ends[i + 1], router)) left_out = true;
    }
    if (!left_out) ++whole;
  }
  tour.cells = whole;
  tour.cells_left_out = cells.size() - whole;
  return tour;
}

}  // namespace musher::coverage
