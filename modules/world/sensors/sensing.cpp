#include "musher/modules/world/sensors/sensing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "musher/messages/stamp.hpp"
#include "musher/modules/world/body/camera_model.hpp"
#include "musher/modules/world/sensors/ranging.hpp"

namespace musher::world {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kEarthRadiusM = 6'378'137;
constexpr std::size_t kTofSide = 8;

// Identifies the sensor in the seed of a random generator.
enum class Sensor : std::uint64_t { kLidar = 1, kUltrasonic, kGps, kTof, kUwb };

NormalRandom RandomOf(const World& world, Sensor sensor, std::size_t number = 0) {
  transport::sim::Random seed(world.scene().seed);
  transport::sim::Random of_sensor(seed.Next() + static_cast<std::uint64_t>(sensor) + number);
  return NormalRandom(of_sensor.Next() + static_cast<std::uint64_t>(world.now().count()));
}

// A sensor in the place: what is around it, and the directions of its axes.
struct Eye {
  RayTargets about;
  Matrix3d turned;

  double Look(double yaw, double down) const {
    const Vector3d along(std::cos(down) * std::cos(yaw), std::cos(down) * std::sin(yaw),
                         -std::sin(down));
    return about.DistanceAlong(turned * along);
  }
};

Eye Open(const World& world, const Mount& mount, double most_m) {
  const Pose2& pose = world.body().pose();
  const Attitude& attitude = world.body().attitude();
  const Matrix3d body = Turned(pose.yaw_rad, attitude.pitch_rad, attitude.roll_rad);
  const Vector3d trunk(pose.position_m.x(), pose.position_m.y(), attitude.height_m);
  return {RayTargets(world.scene(), trunk + body * mount.position_m, most_m),
          body * Turned(mount.yaw_rad, mount.pitch_rad, 0)};
}

Mount TofMount(const TofSpec& tof, std::size_t position) {
  const bool rear = position >= msg::SingleTofPayload::kLeftRear;
  const bool left = position % 2 == 0;
  const double side = left ? 1 : -1;
  Mount mount;
  mount.position_m = {rear ? -tof.ahead_m : tof.ahead_m, side * tof.aside_m, tof.up_m};
  mount.yaw_rad = rear ? M_PI - side * tof.outward_rad : side * tof.outward_rad;
  mount.pitch_rad = tof.down_rad;
  return mount;
}

}  // namespace

msg::LaserScan MeasureScan(const World& world) {
  const LidarSpec& lidar = world.scene().sensors.lidar;
  const Eye eye = Open(world, lidar.mount, RayLength(lidar.reach));
  NormalRandom random = RandomOf(world, Sensor::kLidar);
  const double step = (lidar.to_rad - lidar.from_rad) / (lidar.rays - 1);
  msg::LaserScan scan;
  scan.header = {msg::ToStamp(world.now()), "laser_frame"};
  scan.angle_min = static_cast<float>(lidar.from_rad);
  scan.angle_max = static_cast<float>(lidar.to_rad);
  scan.angle_increment = static_cast<float>(step);
  scan.scan_time = static_cast<float>(1 / lidar.reach.rate_hz);
  scan.range_min = static_cast<float>(lidar.reach.least_m);
  scan.range_max = static_cast<float>(lidar.reach.most_m);
  scan.ranges.reserve(static_cast<std::size_t>(lidar.rays));
  for (int i = 0; i < lidar.rays; ++i) {
    const double distance = eye.Look(lidar.from_rad + i * step, 0);
    scan.ranges.push_back(static_cast<float>(Reading(lidar.reach, distance, random)));
  }
  return scan;
}

msg::Range MeasureUltrasonic(const World& world) {
  constexpr int kRings = 4;      // of rays around the one in the middle
  constexpr int kRaysARing = 6;  // more by as many from ring to ring
  const UltrasonicSpec& ultrasonic = world.scene().sensors.ultrasonic;
  const Eye eye = Open(world, ultrasonic.mount, RayLength(ultrasonic.reach));
  double nearest = eye.Look(0, 0);
  for (int ring = 1; ring <= kRings; ++ring) {
    const double off = ultrasonic.cone_rad / 2 * ring / kRings;
    for (int i = 0; i < kRaysARing * ring; ++i) {
      const double turn = 2 * M_PI * i / (kRaysARing * ring);
      nearest = std::min(nearest, eye.Look(off * std::cos(turn), off * std::sin(turn)));
    }
  }
  NormalRandom random = RandomOf(world, Sensor::kUltrasonic);
  msg::Range range;
  range.header = {msg::ToStamp(world.now()), "ultrasonic_frame"};
  range.radiation_type = msg::Range::kUltrasound;
  range.field_of_view = static_cast<float>(ultrasonic.cone_rad);
  range.min_range = static_cast<float>(ultrasonic.reach.least_m);
  range.max_range = static_cast<float>(ultrasonic.reach.most_m);
  range.range = static_cast<float>(Reading(ultrasonic.reach, nearest, random));
  range.variance = static_cast<float>(std::pow(ultrasonic.reach.noise_m, 2));
  return range;
}

msg::SingleTofPayload MeasureTof(const World& world, std::size_t position) {
  const TofSpec& tof = world.scene().sensors.tof;
  const Eye eye = Open(world, TofMount(tof, position), RayLength(tof.reach));
  NormalRandom random = RandomOf(world, Sensor::kTof, position);
  msg::SingleTofPayload payload;
  payload.header = {msg::ToStamp(world.now()), "tof_" + std::string(kTofNames.at(position))};
  payload.data_available = true;
  payload.tof_position = static_cast<std::uint8_t>(position);
  const auto angle = [&](std::size_t zone) {  // of its middle, the first one negative
    return tof.view_rad * ((static_cast<double>(zone) + 0.5) / kTofSide - 0.5);
  };
  constexpr double kScale = 0.001;
  for (std::size_t row = 0; row < kTofSide; ++row) {
    for (std::size_t column = 0; column < kTofSide; ++column) {
      const double distance = Reading(tof.reach, eye.Look(-angle(column), angle(row)), random);
      const bool seen = std::isfinite(distance);
      payload.data.push_back(
          static_cast<float>(seen ? std::round(distance / kScale) * kScale : distance));
      // The farther light went, the less of it returns.
      payload.intensity.push_back(
          static_cast<float>(seen ? std::pow(tof.reach.least_m / distance, 2) : 0));
    }
  }
  return payload;
}

msg::NavSatFix MeasureFix(const World& world) {
  using Fix = msg::NavSatFix;
  using Status = msg::NavSatStatus;
  const GpsSpec& gps = world.scene().sensors.gps;
  Fix fix;
  fix.header = {msg::ToStamp(world.now()), "gps"};
  fix.status.service = Status::kGps;
  if (gps.fix == GpsSpec::Fix::kNone) {
    constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
    fix.status.status = Status::kNoFix;
    fix.latitude = fix.longitude = fix.altitude = kUnknown;
    return fix;
  }
  fix.status.status = gps.fix == GpsSpec::Fix::kFix    ? Status::kFix
                      : gps.fix == GpsSpec::Fix::kSbas ? Status::kSbasFix
                                                       : Status::kGbasFix;
  NormalRandom random = RandomOf(world, Sensor::kGps);
  const Vector3d noise(gps.noise_m, gps.noise_m, 2 * gps.noise_m);
  Vector3d at_m(world.body().pose().position_m.x(), world.body().pose().position_m.y(),
                world.body().attitude().height_m);
  for (double* coordinate = at_m.data(); coordinate != at_m.data() + 3; ++coordinate) {
    *coordinate += noise[coordinate - at_m.data()] * random.Normal();
  }
  constexpr double kDegree = M_PI / 180;
  fix.latitude = gps.latitude_deg + at_m.y() / kEarthRadiusM / kDegree;
  const double parallel_m = kEarthRadiusM * std::cos(gps.latitude_deg * kDegree);
  fix.longitude = std::remainder(gps.longitude_deg + at_m.x() / parallel_m / kDegree, 360);
  fix.altitude = gps.altitude_m + at_m.z();
  for (const int axis : {0, 1, 2}) {
    fix.position_covariance.at(static_cast<std::size_t>(axis) * 4) = noise[axis] * noise[axis];
  }
  fix.position_covariance_type = Fix::kCovarianceDiagonalKnown;
  return fix;
}

msg::UInt8 CountSatellites(const World& world) {
  const GpsSpec& gps = world.scene().sensors.gps;
  const bool fix = gps.fix != GpsSpec::Fix::kNone;
  return {static_cast<std::uint8_t>(fix ? gps.satellites : 0)};
}

std::optional<msg::UwbRaw> MeasureTag(const World& world) {
  constexpr double kRssiAtOneMetre = -60;  // dBm
  constexpr double kShadowed = -10;        // dB, behind something
  constexpr double kNearestM = 0.1;
  const UwbSpec& uwb = world.scene().sensors.uwb;
  const Pose2& pose = world.body().pose();
  const Eigen::Vector2d to_tag = uwb.tag_m - pose.position_m;
  const double distance = std::max(to_tag.norm(), kNearestM);
  if (distance > uwb.most_m) return std::nullopt;
  const double angle = std::remainder(std::atan2(to_tag.y(), to_tag.x()) - pose.yaw_rad, 2 * M_PI);
  const bool hidden = Open(world, {}, distance).Look(angle, 0) < distance;
  NormalRandom random = RandomOf(world, Sensor::kUwb);
  const double measured = std::max(distance + uwb.noise_m * random.Normal(), 0.0);
  const double turned = std::remainder(angle + uwb.noise_rad * random.Normal(), 2 * M_PI);
  const double rssi = kRssiAtOneMetre - 20 * std::log10(distance) + (hidden ? kShadowed : 0);
  msg::UwbRaw raw;
  raw.header = {msg::ToStamp(world.now()), "uwb"};
  raw.dist = static_cast<float>(measured);
  raw.angle = static_cast<float>(turned);
  raw.n_los = hidden ? 1 : 0;
  raw.rssi_1 = static_cast<float>(rssi);
  raw.rssi_2 = static_cast<float>(rssi);
  return raw;
}

}  // namespace musher::world
