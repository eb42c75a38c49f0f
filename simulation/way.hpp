#pragma once
// The way of a machine from one state to another, as people go it: switch by switch.

#include <optional>
#include <vector>

#include "musher/lifecycle/config.hpp"

namespace musher::simulation {

// The fewest switches that lead from `from` to `to`, without TearDown; nullopt: there is no way.
std::optional<std::vector<State>> FindWay(const MachineConfig& config, const State& from,
                                          const State& to);

}  // namespace musher::simulation
