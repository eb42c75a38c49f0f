#pragma once
// The names of the topics and services of CyberDog's manager, and who may use them.

#include "musher/wire/security/extension_interfaces.hpp"

namespace musher::cyberdog {

// Topics that it publishes.
inline constexpr const char* kStateSwitchStatus = "state_switch_status";
inline constexpr const char* kSelfCheckStatus = "self_check_status";
inline constexpr const char* kReadyNotify = "ready_notify";
inline constexpr const char* kManagerErrors = "manager_errors";
inline constexpr const char* kDogSn = "dog_sn";

// Services that change nothing.
inline constexpr const char* kMachineStateValget = "machine_state_valget";
inline constexpr const char* kLowPowerSwitchState = "low_power_switch_state";
inline constexpr const char* kBmsInfo = "bms_info";
inline constexpr const char* kQueryDiviceInfo = "query_divice_info";  // CyberDog's spelling
inline constexpr const char* kUidSn = "uid_sn";
inline constexpr const char* kGetDogSn = "get_dog_sn";

// Topics and a service for the robot's own modules.
inline constexpr const char* kDogWakeup = "dog_wakeup";
inline constexpr const char* kNodeErrors = "node_errors";
inline constexpr const char* kUidSet = "uid_set";
inline constexpr const char* kLowPowerExit = "low_power_exit";

// A topic and services by which a person commands the machine.
inline constexpr const char* kMachineStateSwitch = "machine_state_switch";
inline constexpr const char* kMachineStateSwitchKeep = "machine_state_switch_keep";
inline constexpr const char* kOtaStateSwitch = "ota_state_switch";
inline constexpr const char* kLowPowerEnable = "low_power_enable";
inline constexpr const char* kLowPowerOnoff = "low_power_onoff";
inline constexpr const char* kPoweroff = "poweroff";
inline constexpr const char* kReboot = "reboot";

// All of them, for the permissions.
transport::keys::ExtensionInterfaces Interfaces();

}  // namespace musher::cyberdog
