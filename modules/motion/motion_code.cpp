#include "musher/modules/motion/motion_code.hpp"

#include <array>
#include <cstddef>
#include <utility>

namespace musher::motion {
namespace {

constexpr std::array kOfStatus = {
    std::int32_t{kCodeOk},
    std::int32_t{kCodeOk},  // on its way
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

constexpr std::array<std::pair<MotionKey, const char*>, 21> kMeanings = {{
    {MotionKey::kSwitchEstop, "the board is in its emergency stop"},
    {MotionKey::kBanTransition, "the board does not go from its motion to this one"},
    {MotionKey::kEdamp, "the board is in its damping mode"},
    {MotionKey::kLifted, "the body is lifted"},
    {MotionKey::kOverHeat, "the board is too hot"},
    {MotionKey::kLowBattery, "the board says that the battery is low"},
    {MotionKey::kTransitionTimeout, "the change to the motion took too long"},
    {MotionKey::kExecuteTimeout, "the motion did not end in its time"},
    {MotionKey::kExecuteError, "the motion was not carried out"},
    {MotionKey::kSequenceDefinition, "the sequence is not well defined"},
    {MotionKey::kMotorOffline, "a motor does not answer"},
    {MotionKey::kBoardSilent, "the motion board is silent"},
    {MotionKey::kEstop, "the emergency stop is set; motion 111 (recovery stand) clears it"},
    {MotionKey::kStuck, "the body is stuck"},
    {MotionKey::kOrientation, "the body does not stand upright"},
    {MotionKey::kFootPosition, "the feet are in the wrong place"},
    {MotionKey::kStandStuck, "the body could not stand up"},
    {MotionKey::kMotorOverHeat, "a motor is too hot"},
    {MotionKey::kMotorOverCurrent, "a motor takes too much current"},
    {MotionKey::kMotorError, "a motor reports an error"},
    {MotionKey::kCharging, "the body is being charged"},
}};

}  // namespace

std::int32_t CodeOfStatus(std::int8_t switch_status) {
  const auto index = static_cast<std::size_t>(static_cast<std::uint8_t>(switch_status));
  return index < kOfStatus.size() ? kOfStatus.at(index) : MotionCode(MotionKey::kExecuteError);
}

std::string MotionCodeText(std::int32_t code) {
  for (const auto& [key, meaning] : kMeanings) {
    if (MotionCode(key) == code) return meaning;
  }
  return "";
}

}  // namespace musher::motion
