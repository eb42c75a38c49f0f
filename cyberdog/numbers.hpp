#pragma once
// The numbers and texts of CyberDog's manager for the machine's states. Pure.

#include <cstdint>
#include <optional>
#include <string_view>

#include "musher/lifecycle/state.hpp"

namespace musher::cyberdog {

// The state of a number of protocol/MachineState; nullopt for an unknown number.
std::optional<State> StateOfNumber(std::uint8_t number);

// The text of `machine_state_valget`. States without a text of CyberDog are "unkown", in its
// spelling.
std::string_view TextOf(std::string_view state);

// The number of protocol/StateSwitchStatus: -2 Error, -1 for states without a number.
std::int32_t StatusNumberOf(std::string_view state);

// Whether the manager publishes a switch to that state at its begin, since later no subscriber may
// be left.
bool IsPublishedAtBegin(std::string_view state);

}  // namespace musher::cyberdog
