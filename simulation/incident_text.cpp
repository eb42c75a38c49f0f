// Incidents in words.

#include "musher/simulation/hosts.hpp"
#include "musher/simulation/incident.hpp"

namespace musher::simulation {
namespace {

std::string InMilliseconds(Duration duration) {
  return std::to_string(ToMilliseconds(duration)) + " ms";
}

}  // namespace

std::string Describe(const MachineConfig& config, const Incident& incident) {
  const std::string& who = config.actuators[incident.actuator].name;
  const std::string host(HostName(incident.host));
  const std::string other(HostName(incident.other_host));
  const std::string lasts = " for " + InMilliseconds(incident.lasts);
  switch (incident.kind) {
    case IncidentKind::kCrash:
      return "the process of " + who + " is killed";
    case IncidentKind::kWrongConfig:
      return "the configuration of " + who + " is wrong" + lasts +
             ": its process ends with exit code 2";
    case IncidentKind::kFreeze:
      return "the process of " + who + " is stopped" + lasts;
    case IncidentKind::kHang:
      return "callbacks of " + who + " hang that begin in the next " +
             InMilliseconds(incident.lasts);
    case IncidentKind::kSlow:
      return "callbacks of " + who + " are slow" + lasts;
    case IncidentKind::kFail:
      return "callbacks of " + who + " fail" + lasts;
    case IncidentKind::kLie:
      return who + " says that it is in " + incident.state;
    case IncidentKind::kLoss:
      return "messages are lost" + lasts;
    case IncidentKind::kDelay:
      return "messages are late" + lasts;
    case IncidentKind::kDuplication:
      return "messages come twice" + lasts;
    case IncidentKind::kReordering:
      return "messages overtake each other" + lasts;
    case IncidentKind::kPartition:
      return who + " and the controller do not hear each other" + lasts;
    case IncidentKind::kDeaf:
      return who + " does not hear the controller" + lasts;
    case IncidentKind::kMute:
      return "the controller does not hear " + who + lasts;
    case IncidentKind::kControllerCrash:
      return "the controller is killed, and started again after " + InMilliseconds(incident.lasts);
    case IncidentKind::kControllerFreeze:
      return "the controller is stopped" + lasts;
    case IncidentKind::kRival:
      return "a second controller is started elsewhere";
    case IncidentKind::kTakeover:
      return "a second controller is started elsewhere, with --takeover";
    case IncidentKind::kFullDisk:
      return "the controller's disk is full" + lasts;
    case IncidentKind::kWallClock:
      return "the wall clock jumps";
    case IncidentKind::kSet:
      return "a person asks for " + incident.state;
    case IncidentKind::kSetOne:
      return "a person asks for " + incident.state + " of " + who;
    case IncidentKind::kBattery:
      return "the battery is at " + std::to_string(BatteryOf(incident)) + " %" +
             (ChargesIn(incident) ? ", being charged" : "");
    case IncidentKind::kEmergencyStop:
      return "an emergency stop is engaged";
    case IncidentKind::kRelease:
      return "the emergency stop is released";
    case IncidentKind::kRestart:
      return "a person restarts " + who;
    case IncidentKind::kStillness:
      return incident.chance % 4 == 0 ? "the body moves" : "the body lies still";
    case IncidentKind::kWakeUp:
      return "somebody wakes the robot up";
    case IncidentKind::kKeep:
      return "an application keeps " + incident.state + " for " +
             std::to_string(incident.chance % 8) + " s";
    case IncidentKind::kOta:
      return std::string("an application ") + (incident.chance % 2 == 0 ? "enters" : "leaves") +
             " OTA";
    case IncidentKind::kLowPowerSwitch:
      return std::string("LowPower by lying still is switched ") +
             (incident.chance % 3 == 0 ? "off" : "on");
    case IncidentKind::kPowerOff:
      return "the robot is switched off by its button";
    case IncidentKind::kReboot:
      return "host " + host + " is rebooted and is back after " + InMilliseconds(incident.lasts);
    case IncidentKind::kHostPartition:
      return "hosts " + host + " and " + other + " are cut off from each other" + lasts;
    case IncidentKind::kHostOneWay:
      return "nothing gets from host " + host + " to host " + other + lasts;
    case IncidentKind::kStalledDisk:
      return "the controller's disk stalls" + lasts;
    case IncidentKind::kCrossingStops:
      return "two panels engage an emergency stop, and a release crosses them";
    case IncidentKind::kClientSet:
      return "a client on host " + host + " asks for " + incident.state +
             (incident.chance % 8 == 0 ? " of " + who : "");
    case IncidentKind::kClientStatus:
      return "a client on host " + host + " asks for the status";
    case IncidentKind::kClientRelease:
      return "a client on host " + host + " releases the emergency stops";
    case IncidentKind::kClientRestart:
      return "a client on host " + host + " restarts " + who;
  }
  return {};
}

}  // namespace musher::simulation
