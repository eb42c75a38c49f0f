#pragma once
// The numbers of CyberDog's modules, and their names in the texts of a program that includes this.
//
//   return Error{MakeCode(cyberdog::module_code::kLidar, KeyCode::kTimeout), "the lidar is
//   silent"};

#include "musher/base/code.hpp"

namespace musher::cyberdog {

namespace module_code {
inline constexpr ModuleCode kServer{200};
inline constexpr ModuleCode kBridgeGrpc{300};
inline constexpr ModuleCode kBridgeNet{600};
inline constexpr ModuleCode kApp{700};
inline constexpr ModuleCode kDeviceManager{1000};
inline constexpr ModuleCode kLed{1100};
inline constexpr ModuleCode kMiniLed{1200};
inline constexpr ModuleCode kWifi{1300};
inline constexpr ModuleCode kBms{1400};
inline constexpr ModuleCode kTouch{1500};
inline constexpr ModuleCode kUwb{1600};
inline constexpr ModuleCode kSensorManager{2000};
inline constexpr ModuleCode kLidar{2100};
inline constexpr ModuleCode kTof{2200};
inline constexpr ModuleCode kUltrasonic{2300};
inline constexpr ModuleCode kGps{2400};
inline constexpr ModuleCode kMotionManager{3000};
inline constexpr ModuleCode kMotionBoard{3100};
inline constexpr ModuleCode kMotionUtils{3200};
inline constexpr ModuleCode kFollow{4100};
inline constexpr ModuleCode kAi{4200};
inline constexpr ModuleCode kMapNav{4300};
inline constexpr ModuleCode kCameraServer{4400};
inline constexpr ModuleCode kAudioNx{5000};
inline constexpr ModuleCode kAudioBoard{5100};
inline constexpr ModuleCode kConnector{5200};
inline constexpr ModuleCode kNavigation{5300};
inline constexpr ModuleCode kTransmission{5400};
inline constexpr ModuleCode kFence{5500};
inline constexpr ModuleCode kAft{5600};
inline constexpr ModuleCode kVisualProgram{5800};
inline constexpr ModuleCode kFace{5900};
}  // namespace module_code

// Gives CyberDog's modules their names; see NameModules().
bool NameModuleCodes();

// Calls it before main() of each program that includes this header.
inline const bool kModuleCodesAreNamed = NameModuleCodes();

}  // namespace musher::cyberdog
