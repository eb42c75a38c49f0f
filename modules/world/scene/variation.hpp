#pragma once
// Varies a scene within its limits, by its seed. Each value has random numbers of its own: a limit
// that is added to a scene does not change the other values. Pure functions; no errors.

#include <cstdint>
#include <string>
#include <string_view>

#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

// A random number for that value of a run.
std::uint64_t SampleOf(std::uint64_t seed, std::string_view name);

// Adds what it changed to Scene::sampled. Values stay within the limits of a scene file.
void Vary(const Variation& variation, Scene& scene);

// "seed 3: qr_a = A-1, slip = 0.041"; "seed 3" of a scene in which nothing varies.
std::string SampledText(const Scene& scene);

}  // namespace musher::world
