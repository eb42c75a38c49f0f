#pragma once
// The controller's decision code: Step(config, machine, event, now) changes the machine and gives
// the actions. Pure and deterministic - no clock, no thread, no IO; the shell (controller/) and the
// simulation turn the world into events and actions into the world.
//
// Inside, one step is a chain of parts, each a small class (step/step_part.hpp) that uses only
// those above it:
//   record/       the sentences of what is recorded, each with its event name (event_name.hpp)
//   step/         what every part can do: change the machine, act, record, save; emergency stops;
//                 the processes of the actuators, restarts
//   policy/       the stored values of the policy; power
//   switch/       a switch: its plan, its legs in that order, rollback, result; one command to one
//                 actuator, with a definite outcome; taking control; arrivals; TearDown; requests
//   supervision/  the start: processes, stages, adoption; actuators that crashed, hang or are lost;
//                 joining late; binds_to; on_lost
//   rules/        the policy: its rules, and requests to it
//   authority     another controller leads

#include <optional>
#include <vector>

#include "musher/lifecycle/step/action.hpp"
#include "musher/lifecycle/step/event.hpp"

namespace musher {

// One step of the decision. Events that are not expected any more (a late reply, an exit that was
// seen already) only update what is known about the actuator.
std::vector<Action> Step(const MachineConfig& config, Machine& machine, const Event& event,
                         Time now);

// When to step next with TimePassed, unless another event comes before; nullopt: never.
std::optional<Time> NextDeadline(const MachineConfig& config, const Machine& machine);

// The same for the deadlines of the policy, by its own clock; NextDeadline() includes them unless
// that clock is a topic.
std::optional<Time> NextPolicyDeadline(const MachineConfig& config, const Machine& machine);

}  // namespace musher
