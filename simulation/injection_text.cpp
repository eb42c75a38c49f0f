// Texts of injected events, for timelines.

#include "musher/simulation/hosts.hpp"
#include "musher/simulation/injection.hpp"

namespace musher::simulation {
namespace {

std::string InMilliseconds(Duration duration) {
  return std::to_string(ToMilliseconds(duration)) + " ms";
}

std::string Describe(PermitFault fault, const std::string& actuator) {
  switch (fault) {
    case PermitFault::kConsoleEnds:
      return "the console gives no permits to move";
    case PermitFault::kLost:
      return "permits to move are lost";
    case PermitFault::kLate:
      return "permits to move are late";
    case PermitFault::kCut:
      break;
  }
  return "the link from the console to " + actuator + " is cut";
}

std::string DescribeClock(const Injection& injection) {
  const std::string lasts = " for " + InMilliseconds(injection.lasts);
  switch (ClockFaultOf(injection)) {
    case ClockFault::kRate:
      return "/clock runs at " + std::to_string(ClockRateOf(injection)) + " thousandths" + lasts;
    case ClockFault::kPause:
      return "/clock pauses" + lasts;
    case ClockFault::kBack:
    case ClockFault::kForward:
      return "/clock jumps by " + InMilliseconds(ClockJumpOf(injection));
    case ClockFault::kRestart:
      break;
  }
  return "/clock begins again";
}

}  // namespace

std::string Describe(const MachineConfig& config, const Injection& injection) {
  const std::string& name = config.actuators[injection.actuator].name;
  const std::string host(HostName(injection.host));
  const std::string other(HostName(injection.other_host));
  const std::string lasts = " for " + InMilliseconds(injection.lasts);
  const std::string released = injection.lasts == Duration::zero()
                                   ? ""
                                   : ", released after " + InMilliseconds(injection.lasts);
  switch (injection.kind) {
    case InjectionKind::kCrash:
      return "the process of " + name + " is killed";
    case InjectionKind::kWrongConfig:
      return "the configuration of " + name + " is wrong" + lasts +
             ": its process ends with exit code 2";
    case InjectionKind::kFreeze:
      return "the process of " + name + " is frozen (SIGSTOP)" + lasts;
    case InjectionKind::kHang:
      return "new callbacks of " + name + " hang" + lasts;
    case InjectionKind::kSlow:
      return "callbacks of " + name + " are slow" + lasts;
    case InjectionKind::kFail:
      return "callbacks of " + name + " fail" + lasts;
    case InjectionKind::kLie:
      return name + " publishes the false state " + injection.state;
    case InjectionKind::kLoss:
      return "messages are lost" + lasts;
    case InjectionKind::kDelay:
      return "messages are delayed" + lasts;
    case InjectionKind::kDuplication:
      return "messages are duplicated" + lasts;
    case InjectionKind::kReordering:
      return "messages are reordered" + lasts;
    case InjectionKind::kPartition:
      return "the link between " + name + " and the controller is cut" + lasts;
    case InjectionKind::kDeaf:
      return "the link from the controller to " + name + " is cut" + lasts;
    case InjectionKind::kMute:
      return "the link from " + name + " to the controller is cut" + lasts;
    case InjectionKind::kControllerCrash:
      return "the controller is killed, and restarted after " + InMilliseconds(injection.lasts);
    case InjectionKind::kControllerFreeze:
      return "the controller is frozen (SIGSTOP)" + lasts;
    case InjectionKind::kRival:
      return "a second controller is started";
    case InjectionKind::kTakeover:
      return "a second controller is started with --takeover";
    case InjectionKind::kTakeBack:
      return "the first controller is started again with --takeover";
    case InjectionKind::kFullDisk:
      return "the controller's disk is full" + lasts;
    case InjectionKind::kWallClock:
      return "the wall clock jumps";
    case InjectionKind::kSet:
      return "the operator requests " + injection.state;
    case InjectionKind::kSetOne:
      return "the operator requests " + injection.state + " of " + name;
    case InjectionKind::kBattery:
      return "the battery is at " + std::to_string(BatteryOf(injection)) + " %" +
             (ChargesIn(injection) ? ", charging" : "");
    case InjectionKind::kEmergencyStop:
      return "an emergency stop is engaged";
    case InjectionKind::kRelease:
      return "the emergency stop is released";
    case InjectionKind::kRestart:
      return "the operator restarts " + name;
    case InjectionKind::kStillness:
      return injection.random % 4 == 0 ? "the body moves" : "the body lies still";
    case InjectionKind::kWakeUp:
      return "the robot is woken up";
    case InjectionKind::kKeep:
      return "an application keeps " + injection.state + " for " +
             std::to_string(injection.random % 8) + " s";
    case InjectionKind::kOta:
      return std::string("an application ") + (injection.random % 2 == 0 ? "enters" : "leaves") +
             " OTA";
    case InjectionKind::kLowPowerSwitch:
      return std::string("automatic LowPower when lying still is switched ") +
             (injection.random % 3 == 0 ? "off" : "on");
    case InjectionKind::kPowerOff:
      return "the robot is switched off by its button";
    case InjectionKind::kBatteryGlitch:
      return "one sample of the battery reports " + std::to_string(BatteryOf(injection)) + " %";
    case InjectionKind::kBatteryWriter:
      return "a second program publishes a battery at " + std::to_string(BatteryOf(injection)) +
             " %" + lasts;
    case InjectionKind::kBatteryWalk:
      return "the battery jitters around " + std::to_string(BatteryOf(injection)) + " %" + lasts;
    case InjectionKind::kReboot:
      return "host " + host + " is rebooted and is back after " + InMilliseconds(injection.lasts);
    case InjectionKind::kHostPartition:
      return "the link between hosts " + host + " and " + other + " is cut" + lasts;
    case InjectionKind::kHostOneWay:
      return "the link from host " + host + " to host " + other + " is cut" + lasts;
    case InjectionKind::kStalledDisk:
      return "the controller's disk stalls" + lasts;
    case InjectionKind::kCrossingStops:
      return "two panels engage an emergency stop, and a release crosses them";
    case InjectionKind::kClientSet:
      return "a client on host " + host + " requests " + injection.state +
             (injection.random % 8 == 0 ? " of " + name : "");
    case InjectionKind::kClientStatus:
      return "a client on host " + host + " queries the status";
    case InjectionKind::kClientRelease:
      return "a client on host " + host + " releases the emergency stops";
    case InjectionKind::kClientRestart:
      return "a client on host " + host + " restarts " + name;
    case InjectionKind::kOtherMachine:
      return "another machine of the same namespace is in range" + lasts;
    case InjectionKind::kOuterNetwork:
      return "host " + host + " has no outer network" + lasts;
    case InjectionKind::kLostFiles:
      return "the files of the controller are removed";
    case InjectionKind::kBridge:
      return "a bridge repeats old statuses and heartbeats" + lasts;
    case InjectionKind::kStopProgram:
      return "a program on host " + host + " engages an emergency stop" + released;
    case InjectionKind::kManyStops:
      return "a panel engages emergency stops by the hundred" + released;
    case InjectionKind::kUnnamedStop:
      return "a panel engages an emergency stop without an id" + released;
    case InjectionKind::kSilentBattery:
      return "nothing publishes the battery" + lasts;
    case InjectionKind::kSlowDiscovery:
      return "a client on host " + host + " needs up to 10 s to discover what it calls" + lasts;
    case InjectionKind::kPermitFault:
      return Describe(PermitFaultOf(injection), name) + lasts;
    case InjectionKind::kClockFault:
      return DescribeClock(injection);
    case InjectionKind::kUnreadFolder:
      return "another state folder of the machine may not be read from now on";
  }
  return {};
}

}  // namespace musher::simulation
