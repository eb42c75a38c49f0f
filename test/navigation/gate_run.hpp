#pragma once
// A body on a random map, for 20 s of commands of a source that knows nothing: constant, wild, led
// by a velocity that is measured wrongly; with scans that are lost and late. With and without the
// gate. Deterministic.

#include <cstdint>

namespace musher::navigation::testing {

struct GateRun {
  double least_room_m = 1;  // from the edge of the body to a wall; less than 0: a contact
  double driven_m = 0;
  int updates = 0;
};

GateRun RunThroughGate(std::uint64_t seed, bool gated);

}  // namespace musher::navigation::testing
