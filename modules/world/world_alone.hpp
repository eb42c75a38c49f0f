#pragma once
// A world without a machine around it: on the network until a signal ends it, or off the network
// for a picture of what a scene does by itself.

#include <string>

#include "musher/modules/world/scene.hpp"

namespace musher::world {

// Until SIGINT or SIGTERM; then it draws if the scene asks for it. To be called before any thread
// is made. Gives the exit code.
int RunAlone(const Scene& scene, const std::string& name_space);

// Plays the scene for `time` of world time, as fast as it goes, and draws it. Gives the exit code.
int DrawScene(const Scene& scene, Duration time, const std::string& path);

// The same, and draws what the camera of that name sees at the end.
int ShootScene(const Scene& scene, Duration time, const std::string& camera,
               const std::string& path);

}  // namespace musher::world
