#pragma once
// Reads what stands, lies and is painted in a scene, and the looks of the scene.

#include <string>

#include "musher/base/toml/rows.hpp"
#include "musher/modules/world/scene/scene.hpp"
#include "musher/modules/world/scene_file/scene_course.hpp"

namespace musher::world {

// [[box]], [[wall]], [[circle]], [[ball]], [[board]], [[line]] and [[pad]]. Pictures are relative
// to `folder`.
void ReadThings(config_toml::TableReader& root, const std::string& folder, const Choices& choices,
                config_toml::Findings& findings, Scene& scene);

// [guests] and [[guest]]. Call it last: the paths of guests are checked against the obstacles.
void ReadGuests(config_toml::TableReader& root, config_toml::Findings& findings, Scene& scene);

// The camera of a robot.
config_toml::Rows RobotCameraRows(CameraSpec& camera);

// [ground], [light], [cameras] and [camera.*].
void ReadViews(config_toml::TableReader& root, const std::string& folder,
               config_toml::Findings& findings, Scene& scene);

}  // namespace musher::world
