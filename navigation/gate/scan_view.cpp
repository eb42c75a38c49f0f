#include "musher/navigation/gate/scan_view.hpp"

#include <algorithm>
#include <cmath>

namespace musher::navigation {
namespace {

constexpr Duration kScanClockSet = std::chrono::seconds(1);  // a larger step is none of a late scan
constexpr int kClockDrift = 5000;                            // one part in so many

// A ray that hit nothing is a measurement as well: there is nothing up to its range.
bool HasMeasurement(const Scan& scan) {
  return std::any_of(scan.ranges_m.begin(), scan.ranges_m.end(),
                     [&](float range) { return range >= scan.least_m && range > 0; });
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

bool ScanView::IsNew(Duration stamp, Time now) {
  if (!last_stamp_) return true;
  const Duration step = stamp - *last_stamp_;
  if (step < -kScanClockSet || step > now - last_at_ + kScanClockSet) {
    offset_.reset();
    return true;
  }
  return step > Duration::zero();
}

bool ScanView::Take(const Scan& scan, Duration stamp, Time now) {
  if (!HasMeasurement(scan) || !std::isfinite(scan.from_rad) || !std::isfinite(scan.step_rad)) {
    return false;
  }
  Duration age{};
  if (stamp != Duration::zero()) {
    if (!IsNew(stamp, now)) return false;
    const Duration here = now.time_since_epoch() - stamp;
    offset_ = offset_ ? std::min(here, *offset_ + (now - last_at_) / kClockDrift) : here;
    age = here - *offset_;
    last_stamp_ = stamp;
    last_at_ = now;
  }
  taken_ = now - age;
  points_ = PointsOf(CountedBy(mount_, scan), mount_.on_body);
  return true;
}

void ScanView::Forget() {
  points_.clear();
  taken_.reset();
  last_stamp_.reset();
  offset_.reset();
}

}  // namespace musher::navigation
