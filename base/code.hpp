#pragma once
// Error codes, numbered as CyberDog's: success is 0, every other code is a module's base plus a key
// of 1 to 99. Keys 0 to 20 mean the same for every module, 21 to 99 belong to the module.
//
// Threads: any.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace musher {

enum class KeyCode : std::int32_t {
  kOk = 0,
  kFailed = 1,
  kUninitialized = 2,
  kStateInvalid = 3,
  kStatusError = 4,
  kNetError = 5,
  kPermissionDenied = 6,
  kTimeout = 7,
  kUnSupport = 8,
  kSelfCheckFailed = 9,
  kParametersInvalid = 10,
  kTargetBusy = 11,
  kDeviceError = 12,
  kProtectedError = 13,
};

// The modules of Musher itself. A robot's own are values of this type too: CyberDog's are in
// cyberdog/codes/module_codes.hpp.
enum class ModuleCode : std::int32_t {
  kUnknown = -1,
  kRobot = 100,
  kOta = 5700,
};

// The code of `key` from `module`; plain 0 for kOk.
constexpr std::int32_t MakeCode(ModuleCode module, KeyCode key) {
  return key == KeyCode::kOk ? 0
                             : static_cast<std::int32_t>(module) + static_cast<std::int32_t>(key);
}

// The machine's own codes: module Robot.
constexpr std::int32_t RobotCode(KeyCode key) {
  return MakeCode(ModuleCode::kRobot, key);
}

inline constexpr std::int32_t kCodeOk = 0;
inline constexpr std::int32_t kCodeFailed = RobotCode(KeyCode::kFailed);
inline constexpr std::int32_t kCodeUninitialized = RobotCode(KeyCode::kUninitialized);
inline constexpr std::int32_t kCodeStateInvalid = RobotCode(KeyCode::kStateInvalid);
inline constexpr std::int32_t kCodeStatusError = RobotCode(KeyCode::kStatusError);
inline constexpr std::int32_t kCodeNetError = RobotCode(KeyCode::kNetError);
inline constexpr std::int32_t kCodePermissionDenied = RobotCode(KeyCode::kPermissionDenied);
inline constexpr std::int32_t kCodeTimeout = RobotCode(KeyCode::kTimeout);
inline constexpr std::int32_t kCodeUnSupport = RobotCode(KeyCode::kUnSupport);
inline constexpr std::int32_t kCodeSelfCheckFailed = RobotCode(KeyCode::kSelfCheckFailed);
inline constexpr std::int32_t kCodeParametersInvalid = RobotCode(KeyCode::kParametersInvalid);
inline constexpr std::int32_t kCodeTargetBusy = RobotCode(KeyCode::kTargetBusy);
inline constexpr std::int32_t kCodeProtectedError = RobotCode(KeyCode::kProtectedError);

// The name of a module in texts; it lives as long as the program.
struct ModuleName {
  ModuleCode module;
  std::string_view name;
};

// Gives modules their names in the texts of this process, also a robot's own modules. A name that
// is given again changes nothing. Returns whether all modules have these names now: one that has
// another name already keeps it.
bool NameModules(std::span<const ModuleName> names);

// A code in words: "0 (ok)", "7 (Timeout)", "109 (Robot: SelfCheckFailed)"; "4711" if its module
// has no name.
std::string CodeText(std::int32_t code);

// The text with the codes in it as numbers only: "failed with 3009". Two programs that know
// different modules write the same then.
std::string WithoutModuleNames(const std::string& text);

// A sentence with its code behind it: "the lidar is silent (2012 SensorManager: DeviceError)".
// Without, where the code is 0 or the sentence names it already.
std::string WithCode(const std::string& message, std::int32_t code);

}  // namespace musher
