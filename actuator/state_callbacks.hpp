#pragma once
// What an actuator's class does in which state. No IO, no threads of its own.

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher {

// Runs code that is not ours: its own word, or Failed with what it threw.
Result<> RunGuarded(const std::function<Result<>()>& callback);

class StateCallbacks {
 public:
  void Register(const State& state, std::function<Result<>()> callback);
  // For all states that have none of their own.
  void Register(std::function<Result<>(const State&)> callback);

  // Fails, saying which, when a state of `actuator` has no callback, a callback no state, or
  // something two.
  Result<> Check(const MachineConfig& config, const ActuatorConfig& actuator) const;

  // Those that have a callback of their own; with one for all others the built-in ones, too.
  std::vector<State> States() const;

  // There must be one for `state`.
  Result<> Run(const State& state) const;

 private:
  std::map<State, std::function<Result<>()>> own_;
  std::function<Result<>(const State&)> other_;
  std::optional<std::string> twice_;  // what has two
};

}  // namespace musher
