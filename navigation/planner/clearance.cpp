#include "musher/navigation/planner/clearance.hpp"

#include <algorithm>
#include <cmath>

namespace musher::navigation {
namespace {

constexpr float kNone = 1e20F;  // squared cells: nothing is blocked

// Squared distances along one line of cells: the lower envelope of a parabola above each cell.
class LineOfCells {
 public:
  explicit LineOfCells(int longest)
      : values_(longest), of_parabola_(longest), begins_(longest + 1) {}

  void Transform(float* first, int count, std::size_t stride) {
    for (int i = 0; i < count; ++i) values_[i] = first[i * stride];
    int last = -1;
    for (int i = 0; i < count; ++i) {
      if (values_[i] >= kNone) continue;
      double from = -std::numeric_limits<double>::infinity();
      while (last >= 0) {
        from = Crossing(of_parabola_[last], i);
        if (from > begins_[last]) break;
        --last;
        from = -std::numeric_limits<double>::infinity();
      }
      of_parabola_[++last] = i;
      begins_[last] = from;
    }
    if (last < 0) return;
    begins_[last + 1] = std::numeric_limits<double>::infinity();
    for (int i = 0, at = 0; i < count; ++i) {
      while (begins_[at + 1] < i) ++at;
      const auto away = static_cast<float>(i - of_parabola_[at]);
      first[i * stride] = away * away + values_[of_parabola_[at]];
    }
  }

 private:
  double Crossing(int a, int b) const {
    const double square_a = double{values_[a]} + double(a) * a;
    const double square_b = double{values_[b]} + double(b) * b;
    return (square_b - square_a) / (2.0 * (b - a));
  }

  std::vector<float> values_;
  std::vector<int> of_parabola_;
  std::vector<double> begins_;
};

// From a coordinate to the cell that begins at `cell`; 0 within.
double Outside(double coordinate, int cell) {
  return std::max({cell - coordinate, coordinate - cell - 1, 0.0});
}

}  // namespace

Clearance::Clearance(CellMap map, const std::function<bool()>& stop)
    : map_(std::move(map)), distance_m_(map_.count()) {
  ComputeDistances(stop);
}

void Clearance::ComputeDistances(const std::function<bool()>& stop) {
  for (std::size_t i = 0; i < map_.count(); ++i) distance_m_[i] = map_.blocked[i] ? 0 : kNone;
  LineOfCells line(std::max({map_.size_x, map_.size_y, map_.size_z}));
  const std::size_t row = map_.size_x, layer = row * map_.size_y;
  for (std::size_t begin = 0; begin < map_.count(); begin += row) {
    if (stop && stop()) return;
    line.Transform(&distance_m_[begin], map_.size_x, 1);
  }
  for (int z = 0; z < map_.size_z; ++z) {
    if (stop && stop()) return;
    for (std::size_t x = 0; x < row; ++x) {
      line.Transform(&distance_m_[z * layer + x], map_.size_y, row);
    }
  }
  for (std::size_t column = 0; column < layer && !map_.flat(); ++column) {
    if (column % row == 0 && stop && stop()) return;
    line.Transform(&distance_m_[column], map_.size_z, layer);
  }
  for (float& distance : distance_m_) {
    distance = distance >= kNone
                   ? std::numeric_limits<float>::infinity()
                   : static_cast<float>(std::sqrt(double{distance}) * map_.resolution_m);
  }
  complete_ = true;
}

double Clearance::ToNearestCell(const Point& in_cells, double limit_cells) const {
  const auto from = [&](double at) { return std::max(0, int(std::floor(at - limit_cells))); };
  const auto to = [&](double at, int size) {
    return std::min(size - 1, int(std::floor(at + limit_cells)));
  };
  double nearest = limit_cells * limit_cells;
  const int to_x = to(in_cells.x_m, map_.size_x), to_y = to(in_cells.y_m, map_.size_y);
  const int to_z = to(in_cells.z_m, map_.size_z);
  for (int z = from(in_cells.z_m); z <= to_z; ++z) {
    const double away_z = Outside(in_cells.z_m, z);
    for (int y = from(in_cells.y_m); y <= to_y; ++y) {
      const double away_y = Outside(in_cells.y_m, y);
      const double so_far = away_z * away_z + away_y * away_y;
      if (so_far >= nearest) continue;
      for (int x = from(in_cells.x_m); x <= to_x; ++x) {
        if (!map_.blocked[map_.IndexOf({x, y, z})]) continue;
        const double away_x = Outside(in_cells.x_m, x);
        nearest = std::min(nearest, so_far + away_x * away_x);
      }
    }
  }
  return std::sqrt(nearest);
}

double Clearance::At(const Point& place, double limit_m) const {
  const double limit_cells = std::min(limit_m / map_.resolution_m, 1e6);
  return ToNearestCell(map_.InCells(place), limit_cells) * map_.resolution_m;
}

bool Clearance::Fits(const Point& centre, double radius_m) const {
  const Cell cell = map_.CellOf(centre);
  if (!map_.Has(cell) || map_.blocked[map_.IndexOf(cell)]) return false;
  const Point in_cells = map_.InCells(centre);
  const double off = std::hypot(in_cells.x_m - cell.x - 0.5, in_cells.y_m - cell.y - 0.5,
                                map_.flat() ? 0 : in_cells.z_m - cell.z - 0.5);
  const double of_centre = distance_m_[map_.IndexOf(cell)] / map_.resolution_m;
  const double radius = radius_m / map_.resolution_m;
  const double corner = map_.flat() ? M_SQRT1_2 : std::sqrt(0.75);
  if (of_centre - off - corner >= radius) return true;
  if (of_centre + off - 0.5 < radius) return false;
  return ToNearestCell(in_cells, radius) >= radius;
}

bool Clearance::FitsAlong(const Point& from, const Point& to, double radius_m) const {
  const double length_m = Distance(from, to);
  if (!std::isfinite(length_m) || !Fits(from, radius_m) || !Fits(to, radius_m)) return false;
  // With a known distance to the nearest blocked cell, all places nearer than that need no look.
  const double least_step_m = map_.resolution_m * 0.2;
  const double slack = map_.flat() ? M_SQRT1_2 * 2 : std::sqrt(0.75) * 2;
  double at_m = 0;
  while (at_m < length_m) {
    const Point place = Between(from, to, at_m / length_m);
    if (!Fits(place, radius_m)) return false;
    const double known_m =
        distance_m_[map_.IndexOf(map_.CellOf(place))] - slack * map_.resolution_m;
    at_m += std::max(least_step_m, known_m - radius_m);
  }
  return true;
}

std::vector<Point> NewPoints(const std::vector<Point>& points, const Clearance& clearance,
                             double within_m) {
  std::vector<Point> unknown;
  for (const Point& point : points) {
    if (IsFinite(point) && clearance.At(point, within_m) >= within_m) unknown.push_back(point);
  }
  return unknown;
}

}  // namespace musher::navigation
