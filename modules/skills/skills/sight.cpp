#include "musher/modules/skills/skills/sight.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace musher::skills {
namespace {

bool InView(const navigation::Point& at, const navigation::Pose& from, const View& view) {
  if (view.radius_m > 0 && navigation::Distance(at, from.at) > view.radius_m) return false;
  if (view.angle_rad <= 0) return true;
  const double x_m = at.x_m - from.at.x_m;
  const double y_m = at.y_m - from.at.y_m;
  if (x_m == 0 && y_m == 0) return true;
  return std::abs(navigation::Wrapped(std::atan2(y_m, x_m) - from.yaw_rad)) <= view.angle_rad / 2;
}

}  // namespace

std::string NameOfPrim(const std::string& path) {
  return path.substr(path.find_last_of('/') + 1);
}

Result<std::string> CameraOf(const Robot& robot, const std::string& name) {
  if (robot.HasCamera(name)) return name;
  const std::vector<std::string> cameras = robot.cameras();
  if ((name == "default" || name == "sensor.camera.rgb") && !cameras.empty()) {
    return cameras.front();
  }
  std::string known;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    known += (i == 0 ? "" : i + 1 == cameras.size() ? " and " : ", ") + cameras[i];
  }
  return Error{kCodeParametersInvalid, fmt::format("Camera '{}' not available; {}", name,
                                                   cameras.empty() ? robot.name() + " has no camera"
                                                   : cameras.size() == 1 ? "there is " + known
                                                                         : "there are " + known)};
}

std::vector<Sighting> Sightings(const std::vector<SeenObject>& objects, const std::string& name,
                                const navigation::Pose& from, const View& view) {
  std::vector<Sighting> found;
  for (const SeenObject& object : objects) {
    const bool named = name.empty() || object.name == name || object.category == name;
    if (!named || !navigation::IsFinite(object.pose)) continue;
    if (!InView(object.pose.at, from, view)) continue;
    found.push_back({object, navigation::Distance(object.pose.at, from.at)});
  }
  std::ranges::stable_sort(found, {}, &Sighting::distance_m);
  return found;
}

std::string SightingText(const Sighting& sighting) {
  const navigation::Point& at = sighting.object.pose.at;
  return fmt::format("{} at ({:.2f}, {:.2f}, {:.2f}), {:.1f}m away", sighting.object.name, at.x_m,
                     at.y_m, at.z_m, sighting.distance_m);
}

void DetailSightings(const std::vector<Sighting>& sightings, skill::Tick& tick) {
  tick.Detail("count", static_cast<std::int64_t>(sightings.size()));
  if (sightings.empty()) return;
  std::string names;
  for (const Sighting& sighting : sightings) {
    names += (names.empty() ? "" : ", ") + sighting.object.name;
  }
  const Sighting& nearest = sightings.front();
  const navigation::Point& at = nearest.object.pose.at;
  tick.Detail("names", names);
  tick.Detail("name", nearest.object.name);
  tick.Detail("position", skill::Numbers{at.x_m, at.y_m, at.z_m});
  tick.Detail("distance_m", nearest.distance_m);
}

}  // namespace musher::skills
