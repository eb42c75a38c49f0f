#pragma once
// CyberDog's phrases for faults. Pure.

#include <cstdint>
#include <optional>
#include <string_view>

namespace musher::cyberdog {

// The phrase for a failed self-check of `actuator`, by its code; nullopt: none.
std::optional<std::uint16_t> SelfCheckSound(std::string_view actuator, std::int32_t code);

// The phrase for a failed switch, by its code, which names the module. A self-check's code has its
// own phrase.
std::optional<std::uint16_t> SwitchSound(std::int32_t code);

}  // namespace musher::cyberdog
