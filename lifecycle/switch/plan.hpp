#pragma once
// What a switch would do: which actuators are driven, in which order and until when, which are left
// out and why, and whether the switch would be refused. A switch executes exactly its plan.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/lifecycle/machine/machine.hpp"

namespace musher {

struct PlanStep : ActuatorGoal {
  enum class Part {
    kDriven,
    kInTarget,      // is already in the target state
    kHeldInTarget,  // is in the target state, and is attached to the machine again
    kStaysHeld,     // is held below the target, and this switch raises it not
    kUnsupported,   // does not list the target
    kLeftOut,       // not available, not checked, or still starting: `note` says which
  };

  Part part = Part::kDriven;
  int wave = 0;  // depth in `needs`, from 1; 0 when not driven
  Duration deadline{};
  std::string note;

  bool driven() const { return part == Part::kDriven; }

  friend bool operator==(const PlanStep&, const PlanStep&) = default;
};

struct Plan : SwitchGoal {
  std::optional<Error> refusal;  // set: the switch would be refused, and why
  // Set with a refusal with TargetBusy when only busy actuators block the switch: by then each of
  // them is free or known not to be. A request waits for that.
  std::optional<Time> free_by;
  std::vector<PlanStep> steps;  // every actuator concerned, in the config's order

  friend bool operator==(const Plan&, const Plan&) = default;
};

// The plan for taking the machine (or `only`) to `target` from its present state. Checks everything
// except whether another switch is under way.
Plan MakePlan(const MachineConfig& config, const Machine& machine, const State& target,
              std::optional<ActuatorIndex> only = std::nullopt);

// The same of a switch that no person has requested: it raises no actuator that a person holds. Nor
// does any switch down.
Plan MakePolicyPlan(const MachineConfig& config, const Machine& machine, const State& target);

// The plan for a safe state: the on_lost of an actuator, or the battery's limit. The flow is
// ignored: a less active state can always be reached.
Plan MakeSafetyPlan(const MachineConfig& config, const Machine& machine, const State& target);

// Whether the switch leads down and raises no actuator (RaisesNothing()), also after it has waited
// for one that is busy: then its request is obeyed, however late it comes. Always of TearDown and
// Error.
bool OnlyLowers(const MachineConfig& config, const Machine& machine, const Plan& plan);

// Whether a present actuator is a ROS 2 node that is unconfigured: its configuration has failed, or
// error processing has unconfigured it. A SelfCheck configures it, and so does a switch up or to
// the current state.
bool IsUnconfigured(const MachineConfig& config, ActuatorIndex actuator,
                    const KnownActuator& known);

}  // namespace musher
