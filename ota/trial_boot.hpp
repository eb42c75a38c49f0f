#pragma once
// Evaluates a trial boot from the machine, after each of its steps. Pure.

#include <optional>
#include <set>

#include "musher/base/result.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/machine.hpp"

namespace musher::ota {

// What an emergency stop has caused in a trial boot, which says nothing of the version.
struct UnderStop {
  bool start_refused = false;
  std::set<ActuatorIndex> faults;  // of these, seen under a stop, and there since

  // With what the machine shows now.
  void Note(const Machine& machine);
};

// Ok: every stage is up and every critical actuator is well. An Error: why that is no longer
// possible. nullopt: undecided, or the machine is being taken down.
//
// What a stop may have caused leaves it undecided: until the machine is up after all, or another
// critical actuator has a fault.
//
// An actuator that is not critical may fail; it is listed as degraded, as in any start.
std::optional<Result<>> EvaluateTrialBoot(const MachineConfig& config, const Machine& machine,
                                          const UnderStop& stop = {});

}  // namespace musher::ota
