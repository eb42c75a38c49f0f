#pragma once
// What a host has of a machine without its controller (storage/machines_here.hpp finds it).

#include <algorithm>
#include <string>
#include <vector>

#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/lifecycle/machine/stored.hpp"

namespace musher {

struct MachineHere {
  MachineIdentity identity;
  bool lan = false;                       // it may have actuators on other hosts
  std::vector<std::string> interfaces{};  // of its config, to other hosts
  std::vector<std::string> actuators{};   // of its config; empty: it cannot be read
  std::vector<std::string> elsewhere{};   // actuators that its last controller knew on other hosts
  // Actuators whose processes have ended without a TearDown. The state of an actuator is unknown if
  // the controller had ended before the process.
  std::vector<StoredActuator> lost{};
  std::string unread{};  // what this user may not read; empty: nothing

  // Whether an actuator that runs on this host may belong to the machine, by its name.
  bool HasOneOf(const std::vector<std::string>& running_here) const {
    return std::ranges::any_of(running_here, [this](const std::string& name) {
      return std::ranges::count(actuators, name) != 0;
    });
  }

  friend bool operator==(const MachineHere&, const MachineHere&) = default;
};

}  // namespace musher
