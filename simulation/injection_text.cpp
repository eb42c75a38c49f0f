// Injections in words.

#include "musher/simulation/hosts.hpp"
#include "musher/simulation/injection.hpp"

namespace musher::simulation {
namespace {

std::string InMilliseconds(Duration duration) {
  return std::to_string(ToMilliseconds(duration)) + " ms";
}

}  // namespace

std::string Describe(const MachineConfig& config, const Injection& injection) {
  const std::string& who = config.actuators[injection.actuator].name;
  const std::string host(HostName(injection.host));
  const std::string other(HostName(injection.other_host));
  const std::string lasts = " for " + InMilliseconds(injection.lasts);
  switch (injection.kind) {
    case InjectionKind::kCrash:
      return "the process of " + who + " is killed";
    case InjectionKind::kWrongConfig:
      return "the configuration of " + who + " is wrong" + lasts +
             ": its process ends with exit code 2";
    case InjectionKind::kFreeze:
      return "the process of " + who + " is stopped" + lasts;
    case InjectionKind::kHang:
      return "callbacks of " + who + " hang that begin in the next " +
             InMilliseconds(injection.lasts);
    case InjectionKind::kSlow:
      return "callbacks of " + who + " are slow" + lasts;
    case InjectionKind::kFail:
      return "callbacks of " + who + " fail" + lasts;
    case InjectionKind::kLie:
      return who + " says that it is in " + injection.state;
    case InjectionKind::kLoss:
      return "messages are lost" + lasts;
    case InjectionKind::kDelay:
      return "messages are late" + lasts;
    case InjectionKind::kDuplication:
      return "messages come twice" + lasts;
    case InjectionKind::kReordering:
      return "messages overtake each other" + lasts;
    case InjectionKind::kPartition:
      return who + " and the controller do not hear each other" + lasts;
    case InjectionKind::kDeaf:
      return who + " does not hear the controller" + lasts;
    case InjectionKind::kMute:
      return "the controller does not hear " + who + lasts;
    case InjectionKind::kControllerCrash:
      return "the controller is killed, and started again after " + InMilliseconds(injection.lasts);
    case InjectionKind::kControllerFreeze:
      return "the controller is stopped" + lasts;
    case InjectionKind::kRival:
      return "a second controller is started elsewhere";
    case InjectionKind::kTakeover:
      return "a second controller is started elsewhere, with --takeover";
    case InjectionKind::kFullDisk:
      return "the controller's disk is full" + lasts;
    case InjectionKind::kWallClock:
      return "the wall clock jumps";
    case InjectionKind::kSet:
      return "a person asks for " + injection.state;
    case InjectionKind::kSetOne:
      return "a person asks for " + injection.state + " of " + who;
    case InjectionKind::kBattery:
      return "the battery is at " + std::to_string(BatteryOf(injection)) + " %" +
             (ChargesIn(injection) ? ", being charged" : "");
    case InjectionKind::kEmergencyStop:
      return "an emergency stop is engaged";
    case InjectionKind::kRelease:
      return "the emergency stop is released";
    case InjectionKind::kRestart:
      return "a person restarts " + who;
    case InjectionKind::kStillness:
      return injection.chance % 4 == 0 ? "the body moves" : "the body lies still";
    case InjectionKind::kWakeUp:
      return "somebody wakes the robot up";
    case InjectionKind::kKeep:
      return "an application keeps " + injection.state + " for " +
             std::to_string(injection.chance % 8) + " s";
    case InjectionKind::kOta:
      return std::string("an application ") + (injection.chance % 2 == 0 ? "enters" : "leaves") +
             " OTA";
    case InjectionKind::kLowPowerSwitch:
      return std::string("LowPower by lying still is switched ") +
             (injection.chance % 3 == 0 ? "off" : "on");
    case InjectionKind::kPowerOff:
      return "the robot is switched off by its button";
    case InjectionKind::kReboot:
      return "host " + host + " is rebooted and is back after " + InMilliseconds(injection.lasts);
    case InjectionKind::kHostPartition:
      return "hosts " + host + " and " + other + " are cut off from each other" + lasts;
    case InjectionKind::kHostOneWay:
      return "nothing gets from host " + host + " to host " + other + lasts;
    case InjectionKind::kStalledDisk:
      return "the controller's disk stalls" + lasts;
    case InjectionKind::kCrossingStops:
      return "two panels engage an emergency stop, and a release crosses them";
    case InjectionKind::kClientSet:
      return "a client on host " + host + " asks for " + injection.state +
             (injection.chance % 8 == 0 ? " of " + who : "");
    case InjectionKind::kClientStatus:
      return "a client on host " + host + " asks for the status";
    case InjectionKind::kClientRelease:
      return "a client on host " + host + " releases the emergency stops";
    case InjectionKind::kClientRestart:
      return "a client on host " + host + " restarts " + who;
  }
  return {};
}

}  // namespace musher::simulation
