#include "musher/lifecycle/state.hpp"

#include <algorithm>

namespace musher {

const std::vector<BuiltInState>& BuiltInStates() {
  static const std::vector<BuiltInState> states = {
      kUninitialized, kSetUp,     kTearDown, kSelfCheck, kActive,
      kDeActive,      kProtected, kLowPower, kOta,       kError};
  return states;
}

bool IsBuiltInState(std::string_view state) {
  const auto& states = BuiltInStates();
  return std::find(states.begin(), states.end(), state) != states.end();
}

std::optional<Rank> BuiltInRank(std::string_view state) {
  constexpr BuiltInState kByRank[] = {kTearDown, kError,     kOta,   kLowPower,
                                      kDeActive, kProtected, kActive};
  const auto* found = std::find(std::begin(kByRank), std::end(kByRank), state);
  if (found == std::end(kByRank)) return std::nullopt;
  return static_cast<Rank>(found - std::begin(kByRank));
}

bool RaisesNothing(std::optional<Rank> from, Rank to) {
  if (from && to < *from) return true;
  const Rank at_rest = *BuiltInRank(kDeActive);
  return to <= at_rest && to <= from.value_or(at_rest);
}

std::uint8_t MachineStateNumber(std::string_view state) {
  const auto& states = BuiltInStates();
  return static_cast<std::uint8_t>(std::find(states.begin(), states.end(), state) - states.begin());
}

}  // namespace musher
