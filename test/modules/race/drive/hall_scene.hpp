#pragma once
// The hall of config/scenes/course.toml with other measures: its lanes, zones, boards, the bar and
// the marker; other floors, and other light.
//
// Frame: that of the scene, metres; the junction of the START lane and lane Q is at (0, 0).
//
// Threads: any.

#include <cmath>
#include <cstdint>
#include <string>

#include "musher/modules/race/hall.hpp"
#include "musher/modules/world/scene/scene.hpp"

namespace musher::race::testing {

// Of the S lane: two arcs, one to the left and one to the right.
struct SCurve {
  double radius_m = 1.6;  // of its middle
  double arc_deg = 50;
};

// A hall in which all follows from the width of the lanes and lines, as in the scene's own.
Hall HallOf(double lane_m, double line_m);

// Moves everything in the scene of config/scenes/course.toml to where the measures have it.
void LayOut(const Hall& hall, const SCurve& s, world::Scene& scene);

enum class Flooring : std::uint8_t { kShipped, kGrey, kOak, kTiles, kBlueMat, kWetSpots };
std::string NameOf(Flooring flooring);

// `share` is that of the scene's light. The cameras expose automatically, at most four times as
// long, and are the noisier the longer.
struct HallLight {
  double temperature_k = 6200;
  double share = 1;
};

// The floor is a picture that is written to the folder of temporary files.
void Furnish(Flooring flooring, std::uint64_t seed, world::Scene& scene);
void Illuminate(const HallLight& light, world::Scene& scene);

}  // namespace musher::race::testing
