#include "musher/cyberdog/sounds.hpp"

#include <algorithm>
#include <array>

#include "musher/base/code.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"

namespace musher::cyberdog {
namespace {

constexpr std::int32_t kCodesOfAModule = 100;

// 0: no such phrase.
struct SoundRow {
  ModuleCode module;
  std::uint16_t self_check;
  std::uint16_t state_switch;
};

// CyberDog's manager plays 31024 and 31025 for sensor and device manager, which are the phrases of
// audio and motion; these are from its AudioPlay.msg.
constexpr std::array<SoundRow, 18> kSoundRows = {{
    {module_code::kGps, 31006, 31016},
    {module_code::kLidar, 31007, 31017},
    {module_code::kTof, 31008, 31018},
    {module_code::kUltrasonic, 31009, 31019},
    {module_code::kBms, 31010, 31020},
    {module_code::kLed, 31011, 31021},
    {module_code::kMiniLed, 31011, 31021},
    {module_code::kTouch, 31012, 31022},
    {module_code::kUwb, 31013, 31023},
    {module_code::kAudioNx, 31014, 31024},
    {module_code::kAudioBoard, 31014, 31024},
    {module_code::kMotionManager, 31015, 31025},
    {module_code::kMotionBoard, 31015, 31025},
    {module_code::kMotionUtils, 31015, 31025},
    {module_code::kSensorManager, 0, 31026},
    {module_code::kDeviceManager, 0, 31027},
    {module_code::kCameraServer, 31054, 0},
    {module_code::kNavigation, 31058, 0},
}};

struct Owner {
  std::string_view actuator;
  ModuleCode module;
};

constexpr std::array<Owner, 5> kOwners = {{
    {"motion_manager", module_code::kMotionManager},
    {"audio", module_code::kAudioNx},
    {"sensor_manager", module_code::kSensorManager},
    {"device_manager", module_code::kDeviceManager},
    {"RealSenseActuator", module_code::kCameraServer},
}};

ModuleCode ModuleOf(std::int32_t code) {
  return static_cast<ModuleCode>(code / kCodesOfAModule * kCodesOfAModule);
}

std::optional<std::uint16_t> SoundOf(ModuleCode module, std::uint16_t SoundRow::*sound) {
  const auto* const row = std::find_if(kSoundRows.begin(), kSoundRows.end(),
                                       [&](const SoundRow& r) { return r.module == module; });
  if (row == kSoundRows.end() || row->*sound == 0) return std::nullopt;
  return row->*sound;
}

}  // namespace

std::optional<std::uint16_t> SelfCheckSound(std::string_view actuator, std::int32_t code) {
  ModuleCode module = ModuleOf(code);
  if (module == ModuleCode::kRobot) {  // the machine reports the actuator lost or silent
    const auto* const owner = std::find_if(kOwners.begin(), kOwners.end(),
                                           [&](const Owner& o) { return o.actuator == actuator; });
    if (owner != kOwners.end()) module = owner->module;
  }
  return SoundOf(module, &SoundRow::self_check);
}

std::optional<std::uint16_t> SwitchSound(std::int32_t code) {
  const ModuleCode module = ModuleOf(code);
  const bool check = code == MakeCode(module, KeyCode::kSelfCheckFailed);
  return SoundOf(module, check ? &SoundRow::self_check : &SoundRow::state_switch);
}

}  // namespace musher::cyberdog
