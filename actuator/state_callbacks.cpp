#include "musher/actuator/state_callbacks.hpp"

#include <exception>
#include <set>
#include <utility>

#include "musher/base/code.hpp"
#include "musher/base/suggest.hpp"

namespace musher {

Result<> RunGuarded(const std::function<Result<>()>& callback) {
  try {
    return callback();
  } catch (const std::exception& e) {
    return Error{kCodeFailed, std::string("the callback threw: ") + e.what()};
  } catch (...) {
    return Error{kCodeFailed, "the callback threw something that is not a std::exception"};
  }
}

void StateCallbacks::Register(const State& state, std::function<Result<>()> callback) {
  if (!own_.emplace(state, std::move(callback)).second) twice_ = "state '" + state + "'";
}

void StateCallbacks::Register(std::function<Result<>(const State&)> callback) {
  if (other_) twice_ = "the states without one of their own";
  other_ = std::move(callback);
}

Result<> StateCallbacks::Check(const MachineConfig& config, const ActuatorConfig& actuator) const {
  if (twice_) return Error{kCodeParametersInvalid, "two callbacks for " + *twice_};
  std::vector<std::string> unlisted;
  for (const auto& [state, callback] : own_) {
    if (!actuator.Lists(state)) unlisted.push_back(state);
  }
  for (const State& state : actuator.states) {
    if (other_ || own_.contains(state)) continue;
    const std::string near = Nearest(state, unlisted);
    return Error{kCodeParametersInvalid,
                 config.file + " lists state '" + state + "' for " + actuator.name +
                     ", but there is no callback for it" +
                     (near.empty() ? ""
                                   : "; did you mean the callback for '" + near +
                                         "', which the config does not list?")};
  }
  for (const auto& [state, callback] : own_) {
    if (actuator.Lists(state)) continue;
    return Error{kCodeParametersInvalid, "there is a callback for state '" + state + "', but " +
                                             config.file + " does not list it for " +
                                             actuator.name + DidYouMean(state, actuator.states)};
  }
  return Ok();
}

std::vector<State> StateCallbacks::States() const {
  std::set<State> states;
  for (const auto& [state, callback] : own_) states.insert(state);
  if (other_) states.insert(BuiltInStates().begin(), BuiltInStates().end());
  states.erase(State(kUninitialized));  // cannot be commanded
  return {states.begin(), states.end()};
}

Result<> StateCallbacks::Run(const State& state) const {
  const auto own = own_.find(state);
  if (own != own_.end()) return RunGuarded(own->second);
  return RunGuarded([&] { return other_(state); });
}

}  // namespace musher
