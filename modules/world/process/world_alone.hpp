#pragma once
// A world without a machine: on the network until a signal ends it, or off the network for a
// picture of a scene that runs by itself.

#include <string>

#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

// Until SIGINT or SIGTERM; then it draws if the scene requests it. Call it before any thread is
// made. Returns the exit code.
int RunAlone(const Scene& scene, const std::string& name_space);

// Runs the scene for `time` of world time, as fast as possible, and draws it. Returns the exit
// code.
int DrawScene(const Scene& scene, Duration time, const std::string& path);

// The same, and draws what the camera of that name sees at the end.
int ShootScene(const Scene& scene, Duration time, const std::string& camera,
               const std::string& path);

}  // namespace musher::world
