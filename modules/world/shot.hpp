#pragma once
// What a camera sees, as a file. For authors of scenes.

#include <string>

#include "musher/lifecycle/result.hpp"
#include "musher/modules/world/render.hpp"
#include "musher/modules/world/world.hpp"

namespace musher::world {

// What camera `index` of the scene would take a picture of now.
View ViewOf(const World& world, std::size_t index);

// Of camera `index` of the scene, from where the body of `world` is.
Result<Image> TakeShot(const World& world, std::size_t index);

// As PNG; the file is there as a whole or not at all.
Result<> SaveImage(const Image& image, const std::string& path);

// The seed of the noise of a camera at a time: the same scene, camera and time are the same noise.
std::uint64_t NoiseSeed(const Scene& scene, std::size_t index, Duration at);

}  // namespace musher::world
