#include "musher/modules/world/scene_file/scene_sensors.hpp"

#include <string_view>

#include "musher/modules/world/scene_file/scene_keys.hpp"

namespace musher::world {
namespace {

using config_toml::Findings;
using config_toml::TableReader;
using keys::Angle;
using keys::Set;

constexpr double kLeastHz = 0.1;
constexpr double kMostHz = 50;  // a reading in each step of the world
constexpr double kFarthestMountM = 1;
constexpr double kMostNoiseM = 10;
constexpr int kMostRays = 4096;
constexpr std::int64_t kMostSatellites = 64;
constexpr double kMostLatitudeDeg = 89;  // at a pole east is nowhere

void ReadReach(TableReader& reader, Reach& reach) {
  Set(reach.least_m, reader.Number("least_m", 0, keys::kFarthestM));
  Set(reach.most_m, reader.Number("most_m", keys::kSmallestM, keys::kFarthestM));
  Set(reach.noise_m, reader.Number("noise_m", 0, kMostNoiseM));
  Set(reach.rate_hz, reader.Number("rate_hz", kLeastHz, kMostHz));
  if (reach.most_m > reach.least_m) return;
  const std::string_view key = reader.Has("most_m") ? "most_m" : "least_m";
  reader.Fault(reader.At(key), key, "expected most_m beyond least_m, it would measure nothing");
}

void ReadMount(TableReader& reader, Mount& mount) {
  int axis = 0;
  for (const char* key : {"x_m", "y_m", "z_m"}) {
    Set(mount.position_m[axis++], reader.Number(key, -kFarthestMountM, kFarthestMountM));
  }
  Set(mount.yaw_rad, Angle(reader, "yaw_deg"));
  Set(mount.pitch_rad, Angle(reader, "pitch_deg", -90, 90));
}

void ReadUltrasonic(TableReader& reader, UltrasonicSpec& ultrasonic) {
  Set(ultrasonic.enabled, reader.Bool("enabled"));
  ReadReach(reader, ultrasonic.reach);
  ReadMount(reader, ultrasonic.mount);
  Set(ultrasonic.cone_rad, Angle(reader, "cone_deg", 1, 120));
}

void ReadTof(TableReader& reader, TofSpec& tof) {
  Set(tof.enabled, reader.Bool("enabled"));
  ReadReach(reader, tof.reach);
  Set(tof.view_rad, Angle(reader, "view_deg", 1, 120));
  Set(tof.ahead_m, reader.Number("ahead_m", 0, kFarthestMountM));
  Set(tof.aside_m, reader.Number("aside_m", 0, kFarthestMountM));
  Set(tof.up_m, reader.Number("up_m", -kFarthestMountM, kFarthestMountM));
  Set(tof.outward_rad, Angle(reader, "outward_deg", -90, 90));
  Set(tof.down_rad, Angle(reader, "down_deg", -90, 90));
}

void ReadGps(TableReader& reader, GpsSpec& gps) {
  using Fix = GpsSpec::Fix;
  Set(gps.enabled, reader.Bool("enabled"));
  Set(gps.latitude_deg, reader.Number("latitude_deg", -kMostLatitudeDeg, kMostLatitudeDeg));
  Set(gps.longitude_deg, reader.Number("longitude_deg", -180, 180));
  Set(gps.altitude_m, reader.Number("altitude_m", -keys::kFarthestM, 10 * keys::kFarthestM));
  Set(gps.noise_m, reader.Number("noise_m", 0, kMostNoiseM));
  Set(gps.rate_hz, reader.Number("rate_hz", kLeastHz, kMostHz));
  Set(gps.fix,
      reader.Choice<Fix>(
          "fix",
          {{"none", Fix::kNone}, {"fix", Fix::kFix}, {"sbas", Fix::kSbas}, {"gbas", Fix::kGbas}}));
  if (const auto satellites = reader.Integer("satellites", 0, kMostSatellites)) {
    gps.satellites = static_cast<int>(*satellites);
  }
}

void ReadUwb(TableReader& reader, UwbSpec& uwb) {
  Set(uwb.enabled, reader.Bool("enabled"));
  Set(uwb.tag_m.x(), reader.Number("tag_x_m", -keys::kFarthestM, keys::kFarthestM));
  Set(uwb.tag_m.y(), reader.Number("tag_y_m", -keys::kFarthestM, keys::kFarthestM));
  Set(uwb.most_m, reader.Number("most_m", keys::kSmallestM, keys::kFarthestM));
  Set(uwb.noise_m, reader.Number("noise_m", 0, kMostNoiseM));
  Set(uwb.noise_rad, Angle(reader, "noise_deg", 0, 90));
  Set(uwb.rate_hz, reader.Number("rate_hz", kLeastHz, kMostHz));
}

}  // namespace

void ReadLidar(TableReader& reader, LidarSpec& lidar) {
  Set(lidar.enabled, reader.Bool("enabled"));
  ReadReach(reader, lidar.reach);
  ReadMount(reader, lidar.mount);
  if (const auto from = reader.Number("from_deg", -180, 180)) lidar.from_rad = *from * M_PI / 180;
  if (const auto to = reader.Number("to_deg", -180, 180)) lidar.to_rad = *to * M_PI / 180;
  if (const auto rays = reader.Integer("rays", 2, kMostRays)) lidar.rays = static_cast<int>(*rays);
  if (lidar.to_rad > lidar.from_rad) return;
  const std::string_view key = reader.Has("to_deg") ? "to_deg" : "from_deg";
  reader.Fault(reader.At(key), key, "expected to_deg beyond from_deg: rays go counter-clockwise");
}

void ReadSensors(TableReader& root, Findings& findings, SensorSpecs& sensors) {
  keys::Section(root, "lidar", findings,
                [&](TableReader& reader) { ReadLidar(reader, sensors.lidar); });
  keys::Section(root, "ultrasonic", findings,
                [&](TableReader& reader) { ReadUltrasonic(reader, sensors.ultrasonic); });
  keys::Section(root, "tof", findings, [&](TableReader& reader) { ReadTof(reader, sensors.tof); });
  keys::Section(root, "gps", findings, [&](TableReader& reader) { ReadGps(reader, sensors.gps); });
  keys::Section(root, "uwb", findings, [&](TableReader& reader) { ReadUwb(reader, sensors.uwb); });
}

}  // namespace musher::world
