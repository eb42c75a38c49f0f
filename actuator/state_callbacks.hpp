#pragma once
// The state callbacks of an actuator. No I/O, no threads of its own.

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher {

// Runs user code: returns its result, or Failed with the exception's text.
Result<> RunGuarded(const std::function<Result<>()>& callback);

class StateCallbacks {
 public:
  void Register(const State& state, std::function<Result<>()> callback);
  // For all states without a callback of their own.
  void Register(std::function<Result<>(const State&)> callback);

  // Fails, naming it, if a state of `actuator` has no callback, a callback has no state, or a state
  // has two callbacks.
  Result<> Check(const MachineConfig& config, const ActuatorConfig& actuator) const;

  // The states with a callback of their own; with a callback for all others the built-in ones, too.
  std::vector<State> States() const;

  // `state` must have a callback.
  Result<> Run(const State& state) const;

 private:
  std::map<State, std::function<Result<>()>> own_;
  std::function<Result<>(const State&)> other_;
  std::optional<std::string> twice_;  // a state with two callbacks
};

}  // namespace musher
