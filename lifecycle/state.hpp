#pragma once
// The states of a machine and of its actuators. A state is a string; the built-in ones have
// CyberDog's names. A config may add its own, with a rank.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace musher {

using State = std::string;

inline constexpr std::string_view kUninitialized = "Uninitialized";
inline constexpr std::string_view kSetUp = "SetUp";
inline constexpr std::string_view kTearDown = "TearDown";
inline constexpr std::string_view kSelfCheck = "SelfCheck";
inline constexpr std::string_view kActive = "Active";
inline constexpr std::string_view kDeActive = "DeActive";
inline constexpr std::string_view kProtected = "Protected";
inline constexpr std::string_view kLowPower = "LowPower";
inline constexpr std::string_view kOta = "OTA";
inline constexpr std::string_view kError = "Error";

// How active a robot is in a state: TearDown 0, Error 1, OTA 2, LowPower 3, DeActive 4, Protected
// 5, Active 6. Uninitialized, SetUp and SelfCheck have none: they are steps of a start, not places
// to stay. A switch to a higher rank goes up, to a lower one down.
using Rank = int;
std::optional<Rank> BuiltInRank(std::string_view state);

// All built-in states in CyberDog's numbering, Uninitialized first.
const std::vector<std::string_view>& BuiltInStates();
bool IsBuiltInState(std::string_view state);

// CyberDog's MachineState number, as FsMachine's `current_state` carries it: Uninitialized 0, SetUp
// 1, TearDown 2, SelfCheck 3, Active 4, DeActive 5, Protected 6, LowPower 7, OTA 8, Error 9, any
// other 10.
std::uint8_t MachineStateNumber(std::string_view state);

}  // namespace musher
