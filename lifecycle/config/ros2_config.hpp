#pragma once
// [ros2] of the state config: the interfaces of the machine for ROS 2's tools.

#include "musher/lifecycle/state.hpp"

namespace musher {

struct Ros2Config {
  // The machine and each of its actuators are offered as managed nodes.
  bool managed_nodes = true;
  // The machine waits in SetUp until a manager configures and activates it.
  bool started_by_manager = false;
  // The states that the transitions of the machine's node switch to.
  State configure{kSelfCheck};
  State activate{kActive};
  State deactivate{kDeActive};
  State cleanup{kTearDown};
  State shutdown{kTearDown};
  bool diagnostics = true;  // publish /diagnostics while it has a subscriber
  bool rosout = true;       // publish warnings and errors on /rosout

  friend bool operator==(const Ros2Config&, const Ros2Config&) = default;
};

}  // namespace musher
