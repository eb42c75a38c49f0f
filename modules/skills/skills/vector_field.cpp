#include "musher/modules/skills/skills/vector_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace musher::skills {
namespace {

constexpr std::size_t kSectors = 72;
constexpr double kSectorRad = 2 * M_PI / kSectors;

using Blocked = std::array<bool, kSectors>;

std::size_t SectorOf(double angle_rad) {
  const double turns = angle_rad / kSectorRad;
  const auto sector = static_cast<long>(std::lround(turns)) % static_cast<long>(kSectors);
  return static_cast<std::size_t>(sector < 0 ? sector + static_cast<long>(kSectors) : sector);
}

double AngleOf(std::size_t sector) {
  return navigation::Wrapped(static_cast<double>(sector) * kSectorRad);
}

Blocked BlockedBy(const std::vector<navigation::Point>& obstacles, const FieldRules& rules) {
  Blocked blocked{};
  const double room_m = rules.radius_m + rules.margin_m;
  for (const navigation::Point& point : obstacles) {
    const double distance = std::hypot(point.x_m, point.y_m);
    if (!std::isfinite(distance) || distance > rules.range_m || distance == 0) continue;
    const double angle = std::atan2(point.y_m, point.x_m);
    const double half = distance <= room_m ? M_PI / 2 : std::asin(room_m / distance);
    for (std::size_t sector = 0; sector < kSectors; ++sector) {
      if (std::abs(navigation::Wrapped(AngleOf(sector) - angle)) < half) blocked[sector] = true;
    }
  }
  return blocked;
}

}  // namespace

std::optional<double> FreeDirection(const std::vector<navigation::Point>& obstacles,
                                    double wanted_rad, double before_rad, const FieldRules& rules) {
  // The weights of VFH+: mostly to where it wants to go, but without a change of mind.
  constexpr double kWanted = 5, kPresent = 2, kBefore = 2;
  const Blocked blocked = BlockedBy(obstacles, rules);
  if (!blocked[SectorOf(wanted_rad)]) return navigation::Wrapped(wanted_rad);
  std::optional<double> best;
  double least = 0;
  for (std::size_t sector = 0; sector < kSectors; ++sector) {
    if (blocked[sector]) continue;
    const double angle = AngleOf(sector);
    const double cost = kWanted * std::abs(navigation::Wrapped(angle - wanted_rad)) +
                        kPresent * std::abs(angle) +
                        kBefore * std::abs(navigation::Wrapped(angle - before_rad));
    if (best && cost >= least) continue;
    best = angle;
    least = cost;
  }
  return best;
}

double FreeAhead(const std::vector<navigation::Point>& obstacles, double radius_m, double kept_m,
                 double most_m) {
  const double room_m = radius_m + kept_m;
  double free_m = most_m;
  for (const navigation::Point& point : obstacles) {
    if (point.x_m <= 0 || std::abs(point.y_m) >= room_m) continue;
    free_m = std::min(free_m, point.x_m - std::sqrt(room_m * room_m - point.y_m * point.y_m));
  }
  return std::max(free_m, 0.0);
}

double SafeSpeed(double free_m) {
  constexpr double kBrakesMPerS2 = 0.5, kReactionS = 0.2;
  const double lost = kBrakesMPerS2 * kReactionS;
  return std::sqrt(lost * lost + 2 * kBrakesMPerS2 * free_m) - lost;
}

}  // namespace musher::skills
