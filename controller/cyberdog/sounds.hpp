#pragma once
// Which phrase of CyberDog tells of which trouble. Pure.

#include <cstdint>
#include <optional>
#include <string_view>

namespace musher::cyberdog {

// What is wrong with `actuator` after a failed self-check, by its code; nullopt: there is no phrase
// for that.
std::optional<std::uint16_t> SelfCheckSound(std::string_view actuator, std::int32_t code);

// Which module did not switch, by the code of a switch. A self-check's code has the phrase of that.
std::optional<std::uint16_t> SwitchSound(std::int32_t code);

}  // namespace musher::cyberdog
