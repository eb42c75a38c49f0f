#pragma once
// A camera's picture as a file. For authors of scenes.

#include <string>

#include "musher/base/result.hpp"
#include "musher/modules/world/render/render.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

// The view of the scene's camera `index` now.
View ViewOf(const World& world, std::size_t index);

// The picture of the scene's camera `index`, from the pose of the body in `world`.
Result<Image> TakeShot(const World& world, std::size_t index);

// The same of the camera of a robot that has one.
View ViewOfRobot(const World& world, std::size_t robot);
Result<Image> TakeShotOfRobot(const World& world, std::size_t robot);

// As PNG; the file is written completely or not at all.
Result<> SaveImage(const Image& image, const std::string& path);

// The seed of a camera's noise at a time: same scene, camera and time give the same noise.
std::uint64_t NoiseSeed(const Scene& scene, std::size_t index, Duration at);

}  // namespace musher::world
