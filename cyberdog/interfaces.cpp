#include "musher/cyberdog/interfaces.hpp"

namespace musher::cyberdog {

transport::keys::ExtensionInterfaces Interfaces() {
  transport::keys::ExtensionInterfaces manager;
  manager.published = {kStateSwitchStatus, kSelfCheckStatus, kReadyNotify, kManagerErrors, kDogSn};
  manager.queries = {
      kMachineStateValget, kLowPowerSwitchState, kBmsInfo, kQueryDiviceInfo, kUidSn, kGetDogSn};
  manager.subscribed = {kDogWakeup, kNodeErrors, kUidSet};
  manager.services = {kLowPowerExit};
  manager.operator_topics = {kMachineStateSwitch};
  manager.operator_services = {kMachineStateSwitchKeep, kOtaStateSwitch, kLowPowerEnable,
                               kLowPowerOnoff,          kPoweroff,       kReboot};
  return manager;
}

}  // namespace musher::cyberdog
