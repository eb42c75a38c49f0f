#include "musher/modules/skills/skills/object_detection.hpp"

#include <fmt/format.h>

#include <cmath>

#include "musher/modules/skills/skills/sight.hpp"

namespace musher::skills {

void ObjectDetection::Declare(skill::Table& table) {
  table.Does("Finds the objects of a class in the view of a camera");
  table.Uses(kCamera);
  table.Takes("camera_name", "default", "a camera of the robot; default: its first one");
  table.Takes("target_class", "car", "the category or the name of an object; empty: all");
  table.Takes("radius", 2.0, "m from the robot that it sees; 0: any distance");
  table.Takes("angle", 2 * M_PI / 3, "rad, the whole angle around straight on; 0: all around");
  initializing_ = table.State("INITIALIZING");
  executing_ = table.State("EXECUTING", std::chrono::seconds(5));
  table.To(initializing_, executing_, "the camera is available");
  table.To(executing_, skill::kSucceeded, "objects have come");
}

skill::Next ObjectDetection::Check(skill::Tick& tick) {
  const auto camera = CameraOf(robot_, tick.parameters.Text("camera_name"));
  if (!camera) return skill::Next::Fail(camera.error().message);
  for (const char* name : {"radius", "angle"}) {
    if (tick.parameters.Number(name) < 0) {
      return skill::Next::Fail(fmt::format("Invalid {}: it is negative", name));
    }
  }
  tick.Report(20, "Preparing camera");
  return skill::Next::To(executing_);
}

skill::Next ObjectDetection::Step(skill::Tick& tick) {
  if (tick.state == initializing_) return Check(tick);
  const auto pose = robot_.pose();
  const auto objects = robot_.Detect();
  if (!objects || !pose || !navigation::IsFinite(*pose)) {
    tick.Report(50, objects ? "Waiting for odometry" : "Waiting for objects");
    return skill::Next::Stay();
  }
  const std::string target = NameOfPrim(tick.parameters.Text("target_class"));
  const View view{tick.parameters.Number("radius"), tick.parameters.Number("angle")};
  const auto found = Sightings(*objects, target, *pose, view);
  tick.Report(70, fmt::format("{} in view", found.size()));
  DetailSightings(found, tick);
  const std::string what = target.empty() ? "object" : target;
  if (found.empty()) return skill::Next::Succeed("Detected: no " + what + " in view");
  return skill::Next::Succeed(fmt::format("Detected: {} x {}, nearest {}", found.size(), what,
                                          SightingText(found.front())));
}

skill::Next ObjectDetection::OnLimit(skill::Tick& tick) {
  const std::string why = robot_.Detect() ? robot_.WhyNoPose() : robot_.WhyNothingSeen();
  return skill::Next::Fail("Timeout: " + why + " after " + skill::SecondsText(tick.elapsed));
}

}  // namespace musher::skills
