#pragma once
// How CyberDog's manager counts and names the states of the machine. Pure.

#include <cstdint>
#include <optional>
#include <string_view>

#include "musher/lifecycle/state.hpp"

namespace musher::cyberdog {

// The state that number `state` of protocol/MachineState asks for; nullopt for one that means
// nothing.
std::optional<State> StateOfNumber(std::uint8_t number);

// The text of `machine_state_valget`. States that CyberDog has no word for are "unkown", as it
// spells it.
std::string_view TextOf(std::string_view state);

// The number of protocol/StateSwitchStatus: -2 Error, -1 for what it has no number for.
std::int32_t StatusNumberOf(std::string_view state);

// Whether the manager tells of a switch to that state when it begins, since later nobody may hear.
bool IsToldAtBegin(std::string_view state);

}  // namespace musher::cyberdog
