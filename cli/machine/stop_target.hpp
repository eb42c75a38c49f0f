#pragma once
// Which machine an emergency stop is for, and by which network it is published, from what this host
// knows without waiting for discovery. Pure: what it knows may be old, incomplete, or of another
// machine, and a stop that reaches too many is better than one that reaches none.

#include <optional>
#include <string>
#include <vector>

#include "musher/controller/client/machine_here.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"

namespace musher::cli {

struct StopBelief {
  std::string word;                         // of --machine: a name, or the beginning of an id
  std::optional<MachineIdentity> led;       // whose controller runs here
  bool runs_here = false;                   // a controller or an actuator of any machine
  std::optional<MachineIdentity> of_files;  // of the state folder or config of this host
};

// The machine of --machine, else the one whose controller runs here. Without a controller here,
// actuators of this host may belong to any machine: then every machine that receives the stop
// stops (an empty identity). Where nothing runs here, the machine of the files of this host is
// meant. A word that begins no id that is known here counts as a name, and a name means every
// machine that has it.
MachineIdentity MachineToStop(const StopBelief& belief);

// The machine of this host that --machine means by the beginning of its id; nullopt: none, or
// several, or the word is a name.
std::optional<MachineIdentity> MachineByFiles(const std::string& word,
                                              const std::vector<MachineHere>& machines);

// How the stop reaches every host of the machine.
struct StopReach {
  bool lan = false;                     // it may have actuators on other hosts
  std::vector<std::string> interfaces;  // of its config

  friend bool operator==(const StopReach&, const StopReach&) = default;
};

// By what this host has of `machine`. Where that is not known, those machines count of which an
// actuator runs here: the files of another one may be old. A word that may begin
// an id may begin that of a machine whose config is known here without its id: it may have other
// hosts, but is not confined to their interfaces. `running_here`: the names of the processes that
// run here.
StopReach ReachOf(const MachineIdentity& machine, const std::string& word,
                  const std::vector<MachineHere>& machines,
                  const std::vector<std::string>& running_here);

}  // namespace musher::cli
