#include "musher/test/navigation/scanned_body.hpp"

#include <algorithm>
#include <cmath>

namespace musher::navigation::testing {

void ScannedBody::Move(const Velocity& command, double seconds) {
  const double share = options_.lag_s > 0 ? 1 - std::exp(-seconds / options_.lag_s) : 1;
  wanted_.x_m_s += share * (command.x_m_s - wanted_.x_m_s);
  wanted_.y_m_s += share * (command.y_m_s - wanted_.y_m_s);
  wanted_.yaw_rad_s += share * (command.yaw_rad_s - wanted_.yaw_rad_s);
  const double x = wanted_.x_m_s - velocity_.x_m_s, y = wanted_.y_m_s - velocity_.y_m_s;
  const double change = std::hypot(x, y), most = options_.acceleration_m_s2 * seconds;
  const double part = change > most ? most / change : 1;
  velocity_.x_m_s += part * x;
  velocity_.y_m_s += part * y;
  velocity_.yaw_rad_s = wanted_.yaw_rad_s;
  const Velocity moved = InBodyFrame(velocity_, -pose_.yaw_rad);
  pose_.at.x_m += moved.x_m_s * seconds;
  pose_.at.y_m += moved.y_m_s * seconds;
  pose_.yaw_rad = Wrapped(pose_.yaw_rad + velocity_.yaw_rad_s * seconds);
}

double ScannedBody::ToWall(double angle_rad) const {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  const CellMap& map = walls_.map();
  for (double at_m = 0; at_m < options_.range_m;) {
    const Cell cell = map.CellOf({pose_.at.x_m + at_m * c, pose_.at.y_m + at_m * s, 0});
    if (!map.Has(cell)) return options_.range_m;
    const double away_m = walls_.OfCell(map.IndexOf(cell));
    if (away_m == 0) return at_m;
    at_m += std::max(0.005, away_m - 2 * map.resolution_m);
  }
  return options_.range_m;
}

Scan ScannedBody::Look(std::mt19937_64& random) const {
  std::uniform_real_distribution<double> noise(-options_.noise_m, options_.noise_m);
  Scan scan{-M_PI, 2 * M_PI / options_.rays, 0.02, options_.range_m - 0.01, {}};
  for (int i = 0; i < options_.rays; ++i) {
    const double range_m = ToWall(pose_.yaw_rad + scan.from_rad + i * scan.step_rad);
    scan.ranges_m.push_back(static_cast<float>(std::max(0.021, range_m + noise(random))));
  }
  return scan;
}

CellMap Fenced(CellMap map) {
  for (int y = 0; y < map.size_y; ++y) {
    for (int x = 0; x < map.size_x; ++x) {
      const bool edge = x == 0 || y == 0 || x == map.size_x - 1 || y == map.size_y - 1;
      if (edge) map.blocked[map.IndexOf({x, y, 0})] = 1;
    }
  }
  return map;
}

}  // namespace musher::navigation::testing
