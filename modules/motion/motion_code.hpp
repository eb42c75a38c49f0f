#pragma once
// The codes of the motion manager, 3000 and more, and the mapping of the board's status to them.

#include <cstddef>
#include <cstdint>
#include <string>

#include "musher/base/code.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"

namespace musher::motion {

enum class MotionKey : std::int32_t {
  kSwitchEstop = 21,
  kBanTransition = 22,
  kEdamp = 23,
  kLifted = 24,
  kOverHeat = 25,
  kLowBattery = 26,
  kTransitionTimeout = 27,
  kExecuteTimeout = 28,
  kExecuteError = 29,
  kSequenceDefinition = 31,
  kMotorOffline = 32,
  kMotorTooHot = 33,
  kMotorOverLoad = 34,
  kBoardSilent = 35,
  kEstop = 40,
  kStuck = 41,
  kOrientation = 50,
  kFootPosition = 51,
  kStandStuck = 52,
  kMotorOverHeat = 53,
  kMotorOverCurrent = 54,
  kMotorError = 55,
  kCharging = 56,
  kEstopReported = 88,  // to node_errors, when an emergency stop begins
};

constexpr std::int32_t MotionCode(KeyCode key) {
  return MakeCode(cyberdog::module_code::kMotionManager, key);
}
constexpr std::int32_t MotionCode(MotionKey key) {
  return static_cast<std::int32_t>(cyberdog::module_code::kMotionManager) +
         static_cast<std::int32_t>(key);
}

// The board's status of a change from one motion to another (MotionStatus.switch_status).
enum class SwitchStatus : std::int8_t {
  kNormal = 0,
  kTransitioning = 1,
  kEstop = 2,
  kEdamp = 3,
  kLifted = 4,
  kBanTransition = 5,
  kOverHeat = 6,
  kLowBattery = 7,
  kOrientation = 8,
  kFootPosition = 9,
  kStandStuck = 10,
  kMotorOverHeat = 11,
  kMotorOverCurrent = 12,
  kMotorError = 13,
  kCharging = 14,
};

// 0 without a fault; an unknown status is an execution error.
std::int32_t CodeOfStatus(std::int8_t switch_status);

// The bits of a motor's BodyState.motor_error.
enum class MotorFault : std::int32_t {
  kTooHot = 1 << 0,
  kOverloaded = 1 << 1,
  kOther = 1 << 2,
  kOffline = 1 << 3,
  kOverCurrent = 1 << 4,
  kDriver = 1 << 5,
  kUnderVoltage = 1 << 6,
  kOverVoltage = 1 << 7,
  kEncoder = 1 << 8,
};

// The code of a motor's BodyState.motor_error, that of its gravest fault; 0 without one.
std::int32_t CodeOfMotorError(std::int32_t motor_error);

// "motor 4 (front left hip)": legs FR, FL, RR, RL, each with abduction, hip and knee.
std::string MotorName(std::size_t motor);
// "too hot, driver"; "" without a fault.
std::string MotorFaultText(std::int32_t motor_error);

// "front left, rear right" of contact bits; "no foot".
std::string FeetText(std::int8_t contact);
// "rear left (up or down), front right (fore or aft)" of a board's footpos_error; "" without one.
std::string FootFaultText(std::int16_t footpos_error);

// Whether a code is a fault of the body or its board, and not of a command.
bool IsBodyFault(std::int32_t code);

// The meaning of a code of the motion manager; "" for a code that it does not use.
std::string MotionCodeText(std::int32_t code);

}  // namespace musher::motion
