#pragma once
// What has to hold in every node of the search. Each judge adds to Notes::wrong what does not; none
// of them asks the decision code, only what is plain to see from outside.

#include <string>

#include "musher/test/search/world.hpp"

namespace musher::search {

struct Before {
  State state;
  Phase phase = Phase::kIdle;
  bool stopped = false;
  bool starting = false;  // it is on its way up after the check
};

// The controller sends a command: nothing rises unless somebody asked for it, or to join.
void CheckCommand(const Model& model, const World& world, const action::SendSwitch& send,
                  Notes& notes);

// An actuator begins a callback by command `number` of `epoch` (0: by itself).
void CheckBeginning(const Model& model, const World& world, std::size_t i, const State& target,
                    std::uint64_t epoch, std::uint64_t number, Notes& notes);

// The controller has taken a step. `before`: how things stood.
// After each step of an actuator; `before`: its report before the step.
void CheckStopped(const Model& model, const World& world, std::size_t i,
                  const ActuatorReport& before, Notes& notes);

// Whether `to` is more active than `from`, both being states to stay in.
bool IsHigher(const MachineConfig& config, const State& to, const State& from);

void CheckStep(const Model& model, const World& world, const Before& before, Notes& notes);

// Somebody is told how the switch ended.
void CheckAnswer(const Model& model, const World& world, const action::AnswerSetState& answer,
                 Notes& notes);

// Nothing is left to happen.
void CheckRest(const Model& model, const World& world, Notes& notes);

}  // namespace musher::search
