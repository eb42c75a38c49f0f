#include "musher/modules/motion/motion_code.hpp"

#include <array>
#include <cstddef>

namespace musher::motion {
namespace {

constexpr std::array kOfStatus = {
    std::int32_t{kCodeOk},
    std::int32_t{kCodeOk},  // in transition
    MotionCode(MotionKey::kSwitchEstop),
    MotionCode(MotionKey::kEdamp),
    MotionCode(MotionKey::kLifted),
    MotionCode(MotionKey::kBanTransition),
    MotionCode(MotionKey::kOverHeat),
    MotionCode(MotionKey::kLowBattery),
    MotionCode(MotionKey::kOrientation),
    MotionCode(MotionKey::kFootPosition),
    MotionCode(MotionKey::kStandStuck),
    MotionCode(MotionKey::kMotorOverHeat),
    MotionCode(MotionKey::kMotorOverCurrent),
    MotionCode(MotionKey::kMotorError),
    MotionCode(MotionKey::kCharging),
};

struct Meaning {
  std::int32_t code;
  const char* text;
};

struct MotorFaultKind {
  MotorFault fault;
  MotionKey key;
  const char* text;
};

// The gravest first.
constexpr std::array kMotorFaults = {
    MotorFaultKind{MotorFault::kTooHot, MotionKey::kMotorTooHot, "too hot"},
    MotorFaultKind{MotorFault::kOffline, MotionKey::kMotorOffline, "offline"},
    MotorFaultKind{MotorFault::kOverloaded, MotionKey::kMotorOverLoad, "overloaded"},
    MotorFaultKind{MotorFault::kOverCurrent, MotionKey::kMotorOverCurrent, "over-current"},
    MotorFaultKind{MotorFault::kDriver, MotionKey::kMotorError, "driver fault"},
    MotorFaultKind{MotorFault::kUnderVoltage, MotionKey::kMotorError, "under-voltage"},
    MotorFaultKind{MotorFault::kOverVoltage, MotionKey::kMotorError, "over-voltage"},
    MotorFaultKind{MotorFault::kEncoder, MotionKey::kMotorError, "encoder fault"},
    MotorFaultKind{MotorFault::kOther, MotionKey::kMotorError, "fault"},
};

constexpr std::array kLegs = {"front right", "front left", "rear right", "rear left"};

constexpr std::array kMeanings = {
    Meaning{MotionCode(KeyCode::kFailed), "a source with higher priority controls the body"},
    Meaning{MotionCode(KeyCode::kStateInvalid), "the state of the machine does not allow it"},
    Meaning{MotionCode(KeyCode::kPermissionDenied), "permission denied"},
    Meaning{MotionCode(KeyCode::kTimeout), "it took too long"},
    Meaning{MotionCode(KeyCode::kUnSupport), "unknown motion for this kind of command"},
    Meaning{MotionCode(KeyCode::kSelfCheckFailed), "the self-check failed"},
    Meaning{MotionCode(KeyCode::kParametersInvalid), "invalid parameters"},
    Meaning{MotionCode(KeyCode::kTargetBusy), "another motion is in progress"},
    Meaning{MotionCode(KeyCode::kProtectedError), "battery low: charge the robot first"},
    Meaning{MotionCode(MotionKey::kSwitchEstop), "the board is in its emergency stop"},
    Meaning{MotionCode(MotionKey::kBanTransition),
            "the board refuses the transition from its present motion"},
    Meaning{MotionCode(MotionKey::kEdamp), "the board is in its damping mode"},
    Meaning{MotionCode(MotionKey::kLifted), "the body is lifted"},
    Meaning{MotionCode(MotionKey::kOverHeat), "the board is too hot"},
    Meaning{MotionCode(MotionKey::kLowBattery), "the board reports a low battery"},
    Meaning{MotionCode(MotionKey::kTransitionTimeout), "timeout of the transition to the motion"},
    Meaning{MotionCode(MotionKey::kExecuteTimeout), "timeout of the motion"},
    Meaning{MotionCode(MotionKey::kExecuteError), "the motion was not executed"},
    Meaning{MotionCode(MotionKey::kSequenceDefinition), "invalid sequence"},
    Meaning{MotionCode(MotionKey::kMotorOffline), "a motor does not respond"},
    Meaning{MotionCode(MotionKey::kMotorTooHot), "a motor reports that it is too hot"},
    Meaning{MotionCode(MotionKey::kMotorOverLoad), "a motor reports that it is overloaded"},
    Meaning{MotionCode(MotionKey::kBoardSilent), "the motion board is silent"},
    Meaning{MotionCode(MotionKey::kEstop),
            "the emergency stop is set; motion 111 (recovery stand) clears it"},
    Meaning{MotionCode(MotionKey::kStuck), "the body is stuck"},
    Meaning{MotionCode(MotionKey::kOrientation), "the body does not stand upright"},
    Meaning{MotionCode(MotionKey::kFootPosition), "the feet are in the wrong place"},
    Meaning{MotionCode(MotionKey::kStandStuck), "the body could not stand up"},
    Meaning{MotionCode(MotionKey::kMotorOverHeat), "a motor is too hot"},
    Meaning{MotionCode(MotionKey::kMotorOverCurrent), "a motor takes too much current"},
    Meaning{MotionCode(MotionKey::kMotorError), "a motor reports an error"},
    Meaning{MotionCode(MotionKey::kCharging), "the body is being charged"},
    Meaning{MotionCode(MotionKey::kEstopReported), "an emergency stop has begun"},
};

}  // namespace

std::int32_t CodeOfStatus(std::int8_t switch_status) {
  const auto index = static_cast<std::size_t>(static_cast<std::uint8_t>(switch_status));
  return index < kOfStatus.size() ? kOfStatus.at(index) : MotionCode(MotionKey::kExecuteError);
}

std::int32_t CodeOfMotorError(std::int32_t motor_error) {
  if (motor_error == 0) return kCodeOk;
  for (const MotorFaultKind& kind : kMotorFaults) {
    if ((motor_error & static_cast<std::int32_t>(kind.fault)) != 0) return MotionCode(kind.key);
  }
  return MotionCode(MotionKey::kMotorError);
}

std::string FeetText(std::int8_t contact) {
  std::string text;
  for (std::size_t leg = 0; leg < kLegs.size(); ++leg) {
    const bool stands = ((contact >> leg) & 1) != 0;
    if (stands) text += std::string(text.empty() ? "" : ", ") + kLegs.at(leg);
  }
  return text.empty() ? "no foot" : text;
}

// From the high end: rear left, rear right, front left, front right; three bits of each.
std::string FootFaultText(std::int16_t footpos_error) {
  constexpr std::array kOrder = {3, 2, 1, 0};
  constexpr std::array kAxes = {"up or down", "left or right", "fore or aft"};
  std::string text;
  int bit = static_cast<int>(kOrder.size() * kAxes.size());
  for (const std::size_t leg : kOrder) {
    std::string axes;
    for (const char* axis : kAxes) {
      --bit;
      const bool wrong = ((static_cast<std::uint16_t>(footpos_error) >> bit) & 1U) != 0;
      if (wrong) axes += std::string(axes.empty() ? "" : ", ") + axis;
    }
    if (axes.empty()) continue;
    text += std::string(text.empty() ? "" : "; ") + kLegs.at(leg) + " (" + axes + ")";
  }
  return text;
}

std::string MotorName(std::size_t motor) {
  constexpr std::array kJoints = {"hip abduction", "hip", "knee"};
  std::string number = "motor " + std::to_string(motor);
  const std::size_t leg = motor / kJoints.size();
  if (leg >= kLegs.size()) return number;
  return number + " (" + kLegs.at(leg) + " " + kJoints.at(motor % kJoints.size()) + ")";
}

std::string MotorFaultText(std::int32_t motor_error) {
  std::string text;
  std::int32_t rest = motor_error;
  const auto add = [&](const std::string& name) { text += (text.empty() ? "" : ", ") + name; };
  for (const MotorFaultKind& kind : kMotorFaults) {
    const auto bit = static_cast<std::int32_t>(kind.fault);
    if ((rest & bit) != 0) add(kind.text);
    rest &= ~bit;
  }
  if (rest != 0) add("error " + std::to_string(rest));
  return text;
}

bool IsBodyFault(std::int32_t code) {
  return code >= MotionCode(MotionKey::kSwitchEstop) &&
         code != MotionCode(MotionKey::kSequenceDefinition) &&
         code != MotionCode(MotionKey::kEstop);
}

std::string MotionCodeText(std::int32_t code) {
  for (const Meaning& meaning : kMeanings) {
    if (meaning.code == code) return meaning.text;
  }
  return "";
}

}  // namespace musher::motion
