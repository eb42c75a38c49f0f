#pragma once
// CyberDog's error codes: success is 0, every other code is a module's base plus a key of 1 to 99.
// Keys 0 to 20 mean the same for every module, 21 to 99 belong to the module.
//
// Threads: any.

#include <cstdint>
#include <string>

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

enum class ModuleCode : std::int32_t {
  kUnknown = -1,
  kRobot = 100,
  kServer = 200,
  kBridgeGrpc = 300,
  kBridgeNet = 600,
  kApp = 700,
  kDeviceManager = 1000,
  kLed = 1100,
  kMiniLed = 1200,
  kWifi = 1300,
  kBms = 1400,
  kTouch = 1500,
  kUwb = 1600,
  kSensorManager = 2000,
  kLidar = 2100,
  kTof = 2200,
  kUltrasonic = 2300,
  kGps = 2400,
  kMotionManager = 3000,
  kMotionBoard = 3100,
  kMotionUtils = 3200,
  kFollow = 4100,
  kAi = 4200,
  kMapNav = 4300,
  kCameraServer = 4400,
  kAudioNx = 5000,
  kAudioBoard = 5100,
  kConnector = 5200,
  kNavigation = 5300,
  kTransmission = 5400,
  kFence = 5500,
  kAft = 5600,
  kOta = 5700,
  kVisualProgram = 5800,
  kFace = 5900,
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

// A code in words: "0 (ok)", "3009 (MotionManager: SelfCheckFailed)", "7 (Timeout)", "4711".
std::string CodeText(std::int32_t code);

// A sentence with its code behind it: "the lidar is silent (2012 (SensorManager: DeviceError))".
// Without, where the code is 0 or the sentence names it already.
std::string WithCode(const std::string& message, std::int32_t code);

}  // namespace musher
