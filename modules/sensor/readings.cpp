#include "musher/modules/sensor/readings.hpp"
#include "musher/base/words.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/messages/stamp.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace musher::sensor {
namespace {

constexpr std::size_t kMostRays = 100'000;

Error Refused(const std::string& why) {
  return {MakeCode(cyberdog::module_code::kSensorManager, KeyCode::kParametersInvalid), why};
}

std::string Number(double number) {
  char text[32];
  std::snprintf(text, sizeof(text), "%g", number);
  return text;
}

// Distances may be infinite, but not NaN or negative.
bool CanBe(float distance) {
  return distance >= 0 || distance == -INFINITY;
}

Result<> CheckLimits(float least, float most) {
  if (std::isfinite(least) && std::isfinite(most) && least >= 0 && least <= most) return Ok();
  return Refused("its range is from " + Number(least) + " to " + Number(most));
}

Result<> CheckDistances(const std::vector<float>& distances) {
  const auto bad = std::find_if_not(distances.begin(), distances.end(), CanBe);
  if (bad == distances.end()) return Ok();
  return Refused("distance " + std::to_string(bad - distances.begin()) + " is " + Number(*bad));
}

std::string Seconds(Duration duration) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.3g s", ToSeconds(duration));
  return text;
}

}  // namespace

Result<> Validate(const msg::LaserScan& scan) {
  if (Result<> limits = CheckLimits(scan.range_min, scan.range_max); !limits) return limits;
  if (scan.ranges.empty() || scan.ranges.size() > kMostRays) {
    return Refused("it has " + Counted(scan.ranges.size(), "ray"));
  }
  if (!scan.intensities.empty() && scan.intensities.size() != scan.ranges.size()) {
    return Refused("it has " + Counted(scan.ranges.size(), "ray") + " and " +
                   Counted(scan.intensities.size(), "intensity", "intensities"));
  }
  for (const float angle : {scan.angle_min, scan.angle_max, scan.angle_increment}) {
    if (!std::isfinite(angle)) return Refused("an angle is " + Number(angle));
  }
  // Some drivers include the last ray, some do not.
  const double turned = static_cast<double>(scan.angle_max) - scan.angle_min;
  const double rays = static_cast<double>(scan.ranges.size());
  if (rays > 1 &&
      (scan.angle_increment == 0 || std::abs(turned / scan.angle_increment + 0.5 - rays) > 1.5)) {
    return Refused("its angles from " + Number(scan.angle_min) + " to " + Number(scan.angle_max) +
                   " by " + Number(scan.angle_increment) + " are not those of " +
                   std::to_string(scan.ranges.size()) + " rays");
  }
  return CheckDistances(scan.ranges);
}

Result<> Validate(const msg::Range& range) {
  if (Result<> limits = CheckLimits(range.min_range, range.max_range); !limits) return limits;
  if (!std::isfinite(range.field_of_view)) {
    return Refused("its field of view is " + Number(range.field_of_view));
  }
  if (!CanBe(range.range)) return Refused("its distance is " + Number(range.range));
  return Ok();
}

Result<> Validate(const msg::SingleTofPayload& tof, std::uint8_t position) {
  if (tof.tof_position != position) {
    return Refused("it is of position " + std::to_string(tof.tof_position) + ", not " +
                   std::to_string(position));
  }
  if (!tof.data_available) return Refused("it reports no data");
  if (tof.data.size() != msg::SingleTofPayload::kZones ||
      (!tof.intensity.empty() && tof.intensity.size() != tof.data.size())) {
    return Refused("it has " + Counted(tof.data.size(), "zone") + " and " +
                   Counted(tof.intensity.size(), "intensity", "intensities") + ", not 64");
  }
  return CheckDistances(tof.data);
}

Result<> Validate(const msg::NavSatFix& fix) {
  using Status = msg::NavSatStatus;
  const auto status = fix.status.status;
  if (status < Status::kUnknown || status > Status::kGbasFix) {
    return Refused("its status is " + std::to_string(status));
  }
  if (status < Status::kFix) return Ok();  // no fix, and the reading says so
  constexpr double kMostLatitude = 90;
  constexpr double kMostLongitude = 180;
  if (!(std::abs(fix.latitude) <= kMostLatitude && std::abs(fix.longitude) <= kMostLongitude)) {
    return Refused("its position is " + Number(fix.latitude) + ", " + Number(fix.longitude));
  }
  return Ok();
}

Result<> StampChecker::Take(std::chrono::nanoseconds stamp, std::chrono::nanoseconds now) {
  // The last one was not ahead when it was taken: the time of day was set back since.
  const bool set_back = last_ && tolerance_ > Duration::zero() && *last_ > now + tolerance_;
  if (set_back) last_.reset();
  if (last_ && stamp <= *last_) {
    return Refused("its stamp is " + Seconds(*last_ - stamp) + " before the last one's");
  }
  if (tolerance_ > Duration::zero()) {
    if (stamp > now + tolerance_) return Refused("its stamp is " + Seconds(stamp - now) + " ahead");
    if (stamp < now - tolerance_) return Refused("it is " + Seconds(now - stamp) + " old");
  }
  last_ = stamp;
  return Ok();
}

bool RateLimit::Take(std::chrono::nanoseconds stamp) {
  if (period_ <= Duration::zero()) return true;
  const Duration jitter = period_ / 10;
  if (due_ && stamp < *due_ - jitter && stamp > *due_ - 2 * period_) return false;
  // Keeps the period, unless a reading came late.
  const bool in_rhythm = due_ && stamp < *due_ + period_ && stamp > *due_ - 2 * period_;
  due_ = (in_rhythm ? *due_ : stamp) + period_;
  return true;
}

std::optional<TofPair::Both> TofPair::Take(msg::SingleTofPayload reading) {
  const std::size_t side = reading.tof_position - left_;
  std::optional<Both> both;
  if (new_.at(side)) both = TakeBoth();
  new_.at(side) = std::move(reading);
  if (new_[0] && new_[1]) both = TakeBoth();
  return both;
}

TofPair::Both TofPair::TakeBoth() {
  Both both;
  const msg::Header& header = (new_[0] ? new_[0] : new_[1])->header;
  for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
    if (new_[side]) {
      both[side] = std::move(*new_[side]);
    } else {
      both[side].header.stamp = header.stamp;
      both[side].tof_position = static_cast<std::uint8_t>(left_ + side);
    }
  }
  new_ = {};
  return both;
}

msg::GpsPayload ToGpsPayload(const msg::NavSatFix& fix) {
  using std::chrono::milliseconds;
  constexpr std::chrono::seconds kGpsBegan(315'964'800);  // 6 January 1980
  constexpr std::chrono::seconds kLeapSeconds(18);        // of UTC since then
  constexpr milliseconds kWeek = std::chrono::hours(7 * 24);
  constexpr std::uint8_t kFixWithHeight = 3;
  const auto since =
      std::chrono::floor<milliseconds>(msg::FromStamp(fix.header.stamp)) - kGpsBegan + kLeapSeconds;
  msg::GpsPayload payload;
  payload.sec = static_cast<std::uint32_t>(fix.header.stamp.sec);
  payload.nanosec = fix.header.stamp.nanosec;
  payload.itow = static_cast<std::uint32_t>(((since % kWeek + kWeek) % kWeek).count());
  if (fix.status.status < msg::NavSatStatus::kFix) return payload;
  payload.fix_type = kFixWithHeight;
  payload.lon = fix.longitude;
  payload.lat = fix.latitude;
  return payload;
}

}  // namespace musher::sensor
