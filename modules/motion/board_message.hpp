#pragma once
// The messages of a motion board on LCM (board.lcm) as values, and back. Bytes from the network are
// not trusted: a wrong length, another type and numbers that are not finite are errors.
//
// Pure functions. Threads: any.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/modules/motion/motion_backend.hpp"

namespace musher::motion {

inline constexpr const char* kCommandChannel = "robot_control_cmd";
inline constexpr const char* kResponseChannel = "robot_control_response";
inline constexpr const char* kTemperatureChannel = "motor_temperature";
inline constexpr const char* kLocalizationChannel = "global_to_robot";
inline constexpr const char* kMotorChannel = "motor_ctrl";  // to the board, of other programs
inline constexpr const char* kGaitFileChannel = "user_gait_file";
inline constexpr const char* kGaitResultChannel = "user_gait_result";

using Bytes = std::span<const std::byte>;

// life_count of the command is that of the wire: 0 to 255, as an int8.
std::vector<std::byte> EncodeCommand(const BodyCommand& command);
Result<BodyCommand> DecodeCommand(Bytes bytes);

// life_count and motor temperatures are not in it. `motor_error` has Musher's bits (MotorFault).
Result<BodyReport> DecodeResponse(Bytes bytes);
// Musher's bits (MotorFault) of a motor's error as the board reports it.
std::int32_t MotorFaultsOf(std::int32_t board_error);

struct BoardLocation {
  Duration timestamp{};  // of the board's clock
  BodyMotion motion;     // without a stamp; the board reports no acceleration
};
Result<BoardLocation> DecodeLocation(Bytes bytes);

using Temperatures = std::array<float, 12>;  // degrees Celsius
Result<Temperatures> DecodeTemperatures(Bytes bytes);

// A text for the board: the definition of a gait. Fails above 60 kB.
Result<std::vector<std::byte>> EncodeGaitFile(const std::string& text);
// Whether the board has accepted it.
Result<bool> DecodeGaitResult(Bytes bytes);

}  // namespace musher::motion
