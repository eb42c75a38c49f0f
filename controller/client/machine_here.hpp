#pragma once
// What a host has of a machine without its controller (storage/machines_here.hpp finds it).

#include <string>
#include <vector>

#include "musher/lifecycle/machine/machine_identity.hpp"

namespace musher {

struct MachineHere {
  MachineIdentity identity;
  bool lan = false;                       // it may have actuators on other hosts
  std::vector<std::string> interfaces{};  // of its config, to other hosts
  std::vector<std::string> actuators{};   // of its config; empty: it cannot be read
  std::vector<std::string> elsewhere{};   // that its last controller knew on other hosts

  friend bool operator==(const MachineHere&, const MachineHere&) = default;
};

}  // namespace musher
