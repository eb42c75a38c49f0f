#pragma once
// A scene from a seed: a hall, rooms with doors, a corridor, a maze or U traps, with a map that is
// wrong in places, persons, faults of what the robots know, and up to three robots. The same seed
// gives the same scene. A robot may arrive, refuse or fail; it must end, and touch nothing.

#include <cstdint>

#include "musher/test/modules/skills/scenes/scene.hpp"

namespace musher::skills::testing {

// Its name has the words that it consists of: "rooms, map lacks a box, 2 persons, jump, 2 robots".
Scene RandomScene(std::uint64_t seed);

// Where that is one of flyers: they fly above the heads of smaller persons, at 2 m, and land where
// their drives have ended. Else as it is.
Scene LandingScene(std::uint64_t seed);

}  // namespace musher::skills::testing
