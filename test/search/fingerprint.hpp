#pragma once
// Which nodes of the search are the same. 128 bits stand for a node: with 10^8 nodes the chance
// that two different ones meet is below 10^-21.
//
// Left out is what no decision looks at: texts, ids of records, durations, the codes of failures.
// Times count from now, stamps by which came later. Actuators with the same config and no order
// among them are interchangeable: the fingerprint does not tell which of them is which.

#include <cstdint>
#include <functional>

#include "musher/test/search/world.hpp"

namespace musher::search {

struct Fingerprint {
  std::uint64_t high = 0;
  std::uint64_t low = 0;

  auto operator<=>(const Fingerprint&) const = default;
};

struct FingerprintHash {
  std::size_t operator()(const Fingerprint& f) const { return f.low; }
};

// A node by its fingerprint. `twins` has a bit for each actuator that stands as an interchangeable
// one before it does: what may happen to it happens to that one, too.
struct Identity {
  Fingerprint fingerprint;
  unsigned twins = 0;
};

Identity IdentityOf(const Model& model, const World& world);

}  // namespace musher::search
