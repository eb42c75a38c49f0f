#pragma once
// A flyer above persons who walk about, for 40 s of velocities of a source that knows nothing, with
// a range sensor that looks down: with noise, with samples that are lost, late and wrong, with a
// height that drifts. With and without the gate's rule. A person is a column on the ground: what
// has only a head is in no cone until the flyer is above it. Deterministic; simulated time.

#include <cstdint>

namespace musher::navigation::testing {

struct DescentRun {
  // Persons onto whom it sinks nearer than 0.25 m, that its sensor has seen long enough to stop.
  int sunk_onto = 0;
  int touched = 0;  // from above, also by who steps below it
  double sunk_m = 0;
  bool landed = false;  // at the end, where it then descends to free ground
};

DescentRun RunDescents(std::uint64_t seed, bool gated);

}  // namespace musher::navigation::testing
