#pragma once
// [ros2] of the state config: what ROS 2's tools see of the machine, and what they may do with it.

#include "musher/lifecycle/state.hpp"

namespace musher {

struct Ros2Config {
  // The machine and each of its actuators are offered as managed nodes.
  bool managed_nodes = true;
  // The machine waits in SetUp until a manager configures and activates it.
  bool started_by_manager = false;
  // Where the transitions of the machine's node take it.
  State configure{kSelfCheck};
  State activate{kActive};
  State deactivate{kDeActive};
  State cleanup{kTearDown};
  State shutdown{kTearDown};
  bool diagnostics = true;  // /diagnostics is published while it has a subscriber
  bool rosout = true;       // warnings and errors go to /rosout

  friend bool operator==(const Ros2Config&, const Ros2Config&) = default;
};

}  // namespace musher
