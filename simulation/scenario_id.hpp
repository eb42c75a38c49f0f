#pragma once
// The name of a scenario, by which it is replayed.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace musher::simulation {

// The events sampled from a seed, or only those of some numbers (from 1).
struct ScenarioId {
  std::uint64_t seed = 0;
  std::optional<std::vector<std::size_t>> only;
  bool bridges = false;  // as in ScenarioOptions
};

}  // namespace musher::simulation
