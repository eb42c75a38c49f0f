#pragma once
// Which states may follow which. The flow is data of the config, plus what no config can remove:
// TearDown is reachable from every state, a self-check may be run in every state of the run phase,
// and a start goes SetUp → SelfCheck → Active.

#include <string_view>
#include <vector>

#include "musher/lifecycle/config/config.hpp"

namespace musher {

// Whether an actuator or a machine in `from` may be switched to `to`. The same state is allowed.
bool FlowAllows(const MachineConfig& config, std::string_view from, std::string_view to);

// Whether `to` is more active than `from`, which an emergency stop forbids. A step of the start
// counts as DeActive.
bool Rises(const MachineConfig& config, std::string_view from, std::string_view to);

// Whether both have a rank, and `to` the lower one.
bool Falls(const MachineConfig& config, std::string_view from, std::string_view to);

// Whether the callback of `to` may switch on again what an emergency stop has switched off in
// `from`: it leads to a state above DeActive and not down. This includes the same state and other
// states of the same rank.
bool SwitchesOnAgain(const MachineConfig& config, std::string_view from, std::string_view to);

// Whether the callback of `to` may switch on what is off in `from`: `to` is another state, and more
// active, or as active above DeActive. While an emergency stop is engaged, such a callback does not
// run.
bool MaySwitchOn(const MachineConfig& config, std::string_view from, std::string_view to);

// Whether a switch of the actuator runs a callback. For a ROS 2 node, both states may stand for the
// same ROS 2 state: then none runs.
bool RunsCallback(const MachineConfig& config, ActuatorIndex actuator, std::string_view from,
                  std::string_view to);

// The states that may follow `from`, in the config's order, without `from` itself.
std::vector<State> Reachable(const MachineConfig& config, std::string_view from);

}  // namespace musher
