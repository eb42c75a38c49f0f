#pragma once
// What the skills of cameras and objects have in common: which camera a parameter names, and which
// objects, nearest first.
//
// Metres, radians; positions in the frame of the map. Pure; any thread.

#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/behavior/skill/skill.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

// The last part of a path of a scene, "/World/box_red", or the name itself.
std::string NameOfPrim(const std::string& path);

// The camera that a parameter names; "default" and "sensor.camera.rgb" are the first one. Fails
// with "Camera 'front' not available; there are left and right".
Result<std::string> CameraOf(const Robot& robot, const std::string& name);

struct Sighting {
  SeenObject object;
  double distance_m = 0;  // from the robot
};

// What a robot can see from where it is.
struct View {
  double radius_m = 0;   // 0: any distance
  double angle_rad = 0;  // the whole horizontal angle around straight on; 0: all around
};

// The objects with this name or category that are in view, nearest first. Empty `name`: all.
std::vector<Sighting> Sightings(const std::vector<SeenObject>& objects, const std::string& name,
                                const navigation::Pose& from, const View& view);

// "box_red at (1.20, 3.40, 0.10), 2.3m away".
std::string SightingText(const Sighting& sighting);
// The details count, names, and of the nearest one name, position and distance_m.
void DetailSightings(const std::vector<Sighting>& sightings, skill::Tick& tick);

}  // namespace musher::skills
