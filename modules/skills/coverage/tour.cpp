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
class TourSearch {
 public:
  TourSearch(const std::vector<Cell>& cells, const std::optional<GroundPoint>& start,
             Router& router)
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
        if (cell != first && !AreJoined(first, cell)) continue;
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
  // The first or the last lane of a cell may be isolated: then another entry leads to the cell.
  bool AreJoined(std::size_t cell, std::size_t other) const {
    for (std::size_t from = 0; from < kEntries; ++from) {
      for (std::size_t to = 0; to < kEntries; ++to) {
        if (ways_m_[cell * kEntries + from][other * kEntries + to] != kNoWay) return true;
      }
    }
    return false;
  }
  // Where there is none, it is the last choice, so that each set of cells has an order.
  double Way(std::size_t from, std::size_t to) const {
    constexpr double kLastChoiceM = 1e7;
    return std::min(ways_m_[from][to], kLastChoiceM);
  }
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

struct CellLane {
  std::size_t cell = 0;
  GroundPoint from;
  GroundPoint to;
};

// A tour over lanes in their order, from one of them on.
struct Attempt {
  Tour tour;
  std::vector<bool> covered;  // by lane
  double length_m = 0;        // of the covered lanes
};

Attempt Cover(const std::vector<CellLane>& lanes, std::size_t first, Router& router) {
  Attempt attempt{{}, std::vector<bool>(lanes.size(), false)};
  for (std::size_t i = first; i < lanes.size(); ++i) {
    const CellLane& lane = lanes[i];
    if (!AppendLane(attempt.tour, lane.from, lane.to, router)) continue;
    attempt.covered[i] = true;
    attempt.length_m += Distance(lane.from, lane.to);
  }
  return attempt;
}

// An attempt that begins on a lane that is isolated leaves out the others: the next one begins on
// the first lane that none has covered, as long as it can cover more.
Attempt BestAttempt(const std::vector<CellLane>& lanes, Router& router) {
  constexpr int kMost = 8;
  std::vector<bool> tried(lanes.size(), false);
  Attempt best;
  for (int count = 0; count < kMost; ++count) {
    double left_m = 0;
    std::size_t first = lanes.size();
    for (std::size_t i = lanes.size(); i-- > 0;) {
      if (tried[i]) continue;
      first = i;
      left_m += Distance(lanes[i].from, lanes[i].to);
    }
    if (first == lanes.size() || (count > 0 && left_m <= best.length_m)) break;
    Attempt attempt = Cover(lanes, first, router);
    for (std::size_t i = 0; i < lanes.size(); ++i) tried[i] = tried[i] || attempt.covered[i];
    if (count == 0 || attempt.length_m > best.length_m) best = std::move(attempt);
  }
  return best;
}

}  // namespace

Tour TourOf(const std::vector<Cell>& cells, const std::optional<GroundPoint>& start,
            Router& router) {
  if (cells.empty()) return {};
  const TourSearch ordering(cells, start, router);
  const std::vector<std::size_t> order = ordering.Order(ordering.LargestPart());
  std::vector<CellLane> lanes;
  for (std::size_t cell = 0; cell < order.size(); ++cell) {
    const std::vector<GroundPoint>& ends = ordering.passage(order[cell]).ends;
    for (std::size_t i = 0; i + 1 < ends.size(); i += 2) {
      lanes.push_back({cell, ends[i], ends[i + 1]});
    }
  }
  Attempt best = BestAttempt(lanes, router);
  std::vector<bool> whole(order.size(), true);
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    if (best.covered[i]) continue;
    whole[lanes[i].cell] = false;
    best.tour.lanes_left_out.push_back({lanes[i].from, lanes[i].to});
  }
  std::vector<bool> joined(cells.size(), false);
  for (const std::size_t passage : order) joined[passage / kEntries] = true;
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    if (joined[cell]) continue;
    for (const Lane& lane : cells[cell].lanes) {
      best.tour.lanes_left_out.push_back({EndOf(lane, false), EndOf(lane, true)});
    }
  }
  best.tour.cells = static_cast<std::size_t>(std::ranges::count(whole, true));
  best.tour.cells_left_out = cells.size() - best.tour.cells;
  return std::move(best.tour);
}

}  // namespace musher::coverage
