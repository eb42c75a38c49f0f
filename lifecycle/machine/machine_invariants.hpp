#pragma once
// What holds for a Machine after every step, whatever happened: the members agree with each other.
// Step() checks it in every build and records a violation; the simulation, the search, the fuzzers
// and the unit tests fail at one.

#include <string>

#include "musher/lifecycle/machine/machine.hpp"

namespace musher {

// How the record of a violation begins.
inline constexpr const char* kBrokenInvariant =
    "a fault of Musher; please report it with this journal: ";

// The first invariant that is broken, with the actuator and the values; empty: all hold.
std::string BrokenInvariant(const MachineConfig& config, const Machine& machine);

}  // namespace musher
