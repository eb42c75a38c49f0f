#include "musher/modules/world/scene_file/scene_sensors.hpp"

#include <string_view>

#include "musher/modules/world/scene_file/scene_keys.hpp"

namespace musher::world {
namespace {

namespace row = config_toml::row;
using config_toml::Rows;
using config_toml::TableReader;

constexpr double kLeastHz = 0.1;
constexpr double kMostHz = 50;  // a reading in each step of the world
constexpr double kFarthestMountM = 1;
constexpr double kMostNoiseM = 10;
constexpr int kMostRays = 4096;
constexpr std::int64_t kMostSatellites = 64;
constexpr double kMostLatitudeDeg = 89;  // at a pole east is nowhere

// Those of `rows` behind those before it.
Rows With(Rows first, const Rows& rows) {
  first.insert(first.end(), rows.begin(), rows.end());
  return first;
}

Rows ReachRows(Reach& reach) {
  const auto check = [&](TableReader& reader) {
    if (reach.most_m > reach.least_m) return;
    const std::string_view key = reader.Has("most_m") ? "most_m" : "least_m";
    reader.Fault(reader.At(key), key, "expected most_m beyond least_m, it would measure nothing");
  };
  return {
      row::Number("least_m", reach.least_m, 0, keys::kFarthestM),
      row::Number("most_m", reach.most_m, keys::kSmallestM, keys::kFarthestM),
      row::Number("noise_m", reach.noise_m, 0, kMostNoiseM),
      row::Number("rate_hz", reach.rate_hz, kLeastHz, kMostHz),
      check,
  };
}

Rows MountRows(Mount& mount) {
  Eigen::Vector3d& at = mount.position_m;
  return {
      row::Number("x_m", at.x(), -kFarthestMountM, kFarthestMountM),
      row::Number("y_m", at.y(), -kFarthestMountM, kFarthestMountM),
      row::Number("z_m", at.z(), -kFarthestMountM, kFarthestMountM),
      keys::Angle("yaw_deg", mount.yaw_rad),
      keys::Angle("pitch_deg", mount.pitch_rad, -90, 90),
  };
}

Rows UltrasonicRows(UltrasonicSpec& ultrasonic) {
  return With({row::Bool("enabled", ultrasonic.enabled)},
              With(With(ReachRows(ultrasonic.reach), MountRows(ultrasonic.mount)),
                   {keys::Angle("cone_deg", ultrasonic.cone_rad, 1, 120)}));
}

Rows TofRows(TofSpec& tof) {
  return With(With({row::Bool("enabled", tof.enabled)}, ReachRows(tof.reach)),
              {
                  keys::Angle("view_deg", tof.view_rad, 1, 120),
                  row::Number("ahead_m", tof.ahead_m, 0, kFarthestMountM),
                  row::Number("aside_m", tof.aside_m, 0, kFarthestMountM),
                  row::Number("up_m", tof.up_m, -kFarthestMountM, kFarthestMountM),
                  keys::Angle("outward_deg", tof.outward_rad, -90, 90),
                  keys::Angle("down_deg", tof.down_rad, -90, 90),
              });
}

Rows GpsRows(GpsSpec& gps) {
  using Fix = GpsSpec::Fix;
  return {
      row::Bool("enabled", gps.enabled),
      row::Number("latitude_deg", gps.latitude_deg, -kMostLatitudeDeg, kMostLatitudeDeg),
      row::Number("longitude_deg", gps.longitude_deg, -180, 180),
      row::Number("altitude_m", gps.altitude_m, -keys::kFarthestM, 10 * keys::kFarthestM),
      row::Number("noise_m", gps.noise_m, 0, kMostNoiseM),
      row::Number("rate_hz", gps.rate_hz, kLeastHz, kMostHz),
      row::Choice(
          "fix", gps.fix,
          {{"none", Fix::kNone}, {"fix", Fix::kFix}, {"sbas", Fix::kSbas}, {"gbas", Fix::kGbas}}),
      row::Integer("satellites", gps.satellites, 0, kMostSatellites),
  };
}

Rows UwbRows(UwbSpec& uwb) {
  return {
      row::Bool("enabled", uwb.enabled),
      keys::Coordinate("tag_x_m", uwb.tag_m.x()),
      keys::Coordinate("tag_y_m", uwb.tag_m.y()),
      row::Number("most_m", uwb.most_m, keys::kSmallestM, keys::kFarthestM),
      row::Number("noise_m", uwb.noise_m, 0, kMostNoiseM),
      keys::Angle("noise_deg", uwb.noise_rad, 0, 90),
      row::Number("rate_hz", uwb.rate_hz, kLeastHz, kMostHz),
  };
}

}  // namespace

Rows LidarRows(LidarSpec& lidar) {
  const auto check = [&](TableReader& reader) {
    if (lidar.to_rad > lidar.from_rad) return;
    const std::string_view key = reader.Has("to_deg") ? "to_deg" : "from_deg";
    reader.Fault(reader.At(key), key, "expected to_deg beyond from_deg: rays go counter-clockwise");
  };
  return With(
      With({row::Bool("enabled", lidar.enabled)}, ReachRows(lidar.reach)),
      With(MountRows(lidar.mount), {row::Degrees("from_deg", lidar.from_rad, -180, 180),
                                    row::Degrees("to_deg", lidar.to_rad, -180, 180),
                                    row::Integer("rays", lidar.rays, 2, kMostRays), check}));
}

Rows RangeDownRows(RangeDownSpec& range) {
  Eigen::Vector3d& at = range.position_m;
  return With(ReachRows(range.reach),
              {row::Number("x_m", at.x(), -kFarthestMountM, kFarthestMountM),
               row::Number("y_m", at.y(), -kFarthestMountM, kFarthestMountM),
               row::Number("z_m", at.z(), -kFarthestMountM, kFarthestMountM),
               keys::Angle("cone_deg", range.cone_rad, 1, 120)});
}

Rows SensorRows(SensorSpecs& sensors) {
  return {
      row::Sub("lidar", LidarRows(sensors.lidar)),
      row::Sub("ultrasonic", UltrasonicRows(sensors.ultrasonic)),
      row::Sub("tof", TofRows(sensors.tof)),
      row::Sub("gps", GpsRows(sensors.gps)),
      row::Sub("uwb", UwbRows(sensors.uwb)),
  };
}

}  // namespace musher::world
