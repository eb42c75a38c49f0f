#include "musher/navigation/gate/scan_view.hpp"

#include <algorithm>
#include <cmath>

namespace musher::navigation {
namespace {

constexpr double kDegreeRad = M_PI / 180;
constexpr double kBesideRayRad = 2.5 * kDegreeRad;  // few rays without a measurement are no gap

// A ray that hit nothing is a measurement as well: there is nothing up to its range.
bool IsMeasurement(float range_m, const Scan& scan) {
  return range_m >= scan.least_m && range_m > 0;
}

bool HasMeasurement(const Scan& scan) {
  return std::ranges::any_of(scan.ranges_m,
                             [&](float range_m) { return IsMeasurement(range_m, scan); });
}

// Why a scan says nothing; empty: it does.
std::string WhyUseless(const Scan& scan) {
  constexpr double kLeastStepRad = 1e-6;
  if (!HasMeasurement(scan)) return "no ray has a measurement";
  const bool finite = std::isfinite(scan.from_rad) && std::isfinite(scan.step_rad);
  if (!finite) return "its angles are not finite";
  const bool turns = scan.ranges_m.size() == 1 || std::abs(scan.step_rad) >= kLeastStepRad;
  return turns ? "" : "its angle step is 0";
}

// From 0 to 359, for angles from -4 pi on.
std::size_t DegreeOf(double angle_rad) {
  return static_cast<std::size_t>(angle_rad / kDegreeRad + 720) % 360;
}

}  // namespace

Scan CountedBy(const ScanMount& mount, const Scan& scan) {
  Scan counted = scan;
  counted.least_m = std::max(scan.least_m, mount.least_m);
  counted.most_m = std::min(scan.most_m, mount.most_m);
  if (mount.upside_down) {
    counted.from_rad = -scan.from_rad;
    counted.step_rad = -scan.step_rad;
  }
  return counted;
}

bool ScanView::Take(const Scan& scan, Duration stamp, Time now) {
  why_refused_ = WhyUseless(scan);
  if (!why_refused_.empty()) return false;
  const auto taken = age_.Take(stamp, now);
  if (!taken) {
    why_refused_ = "its stamp does not follow that of the one before";
    return false;
  }
  taken_ = taken;
  const Scan counted = CountedBy(mount_, scan);
  points_ = PointsOf(counted, mount_.on_body);
  sensor_ = mount_.on_body.at;
  NoteCovered(counted);
  return true;
}

void ScanView::NoteCovered(const Scan& counted) {
  covered_.reset();
  const double beside_rad = std::clamp(std::abs(counted.step_rad) / 2, kBesideRayRad, M_PI / 2);
  for (std::size_t i = 0; i < counted.ranges_m.size(); ++i) {
    const double angle_rad = Wrapped(mount_.on_body.yaw_rad + counted.from_rad +
                                     static_cast<double>(i) * counted.step_rad);
    if (!IsMeasurement(counted.ranges_m[i], counted) || !std::isfinite(angle_rad)) continue;
    const std::size_t last = DegreeOf(angle_rad + beside_rad);
    for (std::size_t at = DegreeOf(angle_rad - beside_rad);; at = (at + 1) % covered_.size()) {
      covered_.set(at);
      if (at == last) break;
    }
  }
}

bool ScanView::Covers(const Point& place) const {
  return covered_[DegreeOf(std::atan2(place.y_m - sensor_.y_m, place.x_m - sensor_.x_m))];
}

void ScanView::Forget() {
  points_.clear();
  taken_.reset();
  age_.Forget();
  why_refused_.clear();
}

}  // namespace musher::navigation
