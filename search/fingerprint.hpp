#pragma once
// Which nodes of the search are the same. A node has 128 bits: with 10^8 nodes the probability of a
// collision is below 10^-21.
//
// Without what no decision depends on: texts, ids of records, durations, the codes of failures.
// Of a process that has exited in a TearDown, its last command and outcome; of a machine that is
// torn down, all that its controller knew of the actuators.
// Times count from now, stamps by their order. Actuators with the same config and no order among
// them are interchangeable: the fingerprint does not distinguish them.

#include <cstdint>
#include <functional>

#include "musher/search/world.hpp"

namespace musher::search {

struct Fingerprint {
  std::uint64_t high = 0;
  std::uint64_t low = 0;

  auto operator<=>(const Fingerprint&) const = default;
};

// A node's fingerprint. `twins` has a bit for each actuator in the same state as an interchangeable
// earlier one, so that its choices are searched for that one only.
struct Identity {
  Fingerprint fingerprint;
  unsigned twins = 0;
};

Identity IdentityOf(const Model& model, const World& world);

}  // namespace musher::search
