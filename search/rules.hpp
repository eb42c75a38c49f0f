#pragma once
// What must hold in every node of the search. Each check adds to Notes::violations. It uses only
// what is visible from outside, never the decision code.

#include <string>

#include "musher/search/world.hpp"

namespace musher::search {

struct Before {
  State state;
  Phase phase = Phase::kIdle;
  bool stopped = false;
  bool starting = false;  // the start has passed its self-check and switches up
};

// The controller sends a command: it leads up only to a requested state, or to join.
void CheckCommand(const Model& model, const World& world, const action::SendSwitch& send,
                  Notes& notes);

// An actuator begins a callback by command `number` of `epoch` (0: by itself).
void CheckBegin(const Model& model, const World& world, ActuatorIndex i, const State& target,
                Epoch epoch, CommandNumber number, Notes& notes);

// After each step of an actuator; `before`: its report before the step.
void CheckStopped(const Model& model, const World& world, ActuatorIndex i,
                  const ActuatorReport& before, Notes& notes);

// After a message of another machine; `before`: the actuator before it.
void CheckUnchanged(const Model& model, const World& world, ActuatorIndex i,
                    const ActuatorCore& before, Notes& notes);

// Whether `to` is more active than `from`; false unless both have a rank.
bool IsHigher(const MachineConfig& config, const State& to, const State& from);

// After each step of the controller; `before`: its state before the step.
void CheckStep(const Model& model, const World& world, const Before& before, Notes& notes);

// The controller starts an actuator's process: not after a TearDown that no person has ended.
void CheckStart(const Model& model, const World& world, ActuatorIndex i, Notes& notes);

// A caller gets the outcome of a switch.
void CheckAnswer(const Model& model, const World& world, const action::AnswerSetState& answer,
                 Notes& notes);

// The rules of the user with a time, after anything has happened; counts in Notes how often their
// times begin, and they are met.
void UpdateTimedRules(const Model& model, World& world, Notes& notes);

// Nothing is left to happen.
void CheckRest(const Model& model, const World& world, Notes& notes);

}  // namespace musher::search
