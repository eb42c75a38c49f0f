#pragma once
// The path of a machine from one state to another, switch by switch, as an operator takes it.

#include <optional>
#include <vector>

#include "musher/lifecycle/config/config.hpp"

namespace musher::simulation {

// The fewest switches that lead from `from` to `to`, without TearDown; nullopt: there is none.
std::optional<std::vector<State>> FindPath(const MachineConfig& config, const State& from,
                                           const State& to);

}  // namespace musher::simulation
