// Of the policy: the battery, lying still, keep and power-off.

#include <chrono>

#include "musher/lifecycle/record/texts.hpp"

namespace musher::texts {
namespace {

std::string InSeconds(Duration duration) {
  return std::to_string(std::chrono::duration_cast<std::chrono::seconds>(duration).count()) + " s";
}

std::string LimitText(BatteryLimit limit, const State& most) {
  switch (limit) {
    case BatteryLimit::kAsBefore:
      return "";
    case BatteryLimit::kLifted:
      return ": the machine is no longer limited";
    case BatteryLimit::kNoSwitchAbove:
      return ": no switch above " + most;
    case BatteryLimit::kEmpty:
      return ": it is empty";
    case BatteryLimit::kLimited:
      break;
  }
  return ": the machine is limited to " + most;
}

}  // namespace

RecordText PolicyRequested(const std::string& what, const State& target) {
  return {EventName::kPolicyRequested, what + " requested", target};
}

RecordText PolicyRefused(const std::string& what, const std::string& why) {
  return {EventName::kPolicyRefused, what + " refused: " + why};
}

RecordText BatterySampleInvalid(int percent) {
  return {EventName::kBatterySampleInvalid,
          "the battery reports " + std::to_string(percent) +
              " %, which is out of range; such values are ignored"};
}

RecordText BatterySilent(Duration limit, std::optional<int> last) {
  return {EventName::kBatterySilent,
          "no battery sample for " + InSeconds(limit) +
              (last ? "; its last value, " + std::to_string(*last) + " %, stays in effect"
                    : "; its level is unknown")};
}

RecordText BatteryResumed() {
  return {EventName::kBatteryResumed, "battery samples received again"};
}

RecordText BatteryChanged(const std::string& battery, std::optional<bool> charger,
                          BatteryLimit limit, const State& most) {
  const EventName of_charger =
      charger.value_or(false) ? EventName::kChargerConnected : EventName::kChargerDisconnected;
  return {limit == BatteryLimit::kAsBefore ? of_charger : EventName::kBatteryLevelChanged,
          battery +
              (!charger   ? ""
               : *charger ? ": charger connected"
                          : ": charger disconnected") +
              LimitText(limit, most)};
}

RecordText BatterySwitchDown(const std::string& battery, const State& target) {
  return {EventName::kBatterySwitchDown, battery + ": down to " + target, target};
}

RecordText BatterySwitchUp(const std::string& battery, const State& target) {
  return {EventName::kBatterySwitchUp, battery + ": back to " + target, target};
}

RecordText LyingStill(Duration limit) {
  return {EventName::kLyingStillSwitch,
          "the robot has lain still for " + InSeconds(limit) + ": down to LowPower",
          State(kLowPower)};
}

RecordText PolicySwitchRefused(const RecordText& wanted, const std::string& why) {
  return {EventName::kPolicySwitchRefused, wanted.message + " refused: " + why};
}

RecordText KeepEnded(const State& state, const std::string& why) {
  return {EventName::kKeepEnded, "the machine is no longer kept in " + state + ": " + why};
}

RecordText PowerDownStarted(bool reboot) {
  if (reboot) return {EventName::kRebootStarted, "the robot reboots"};
  return {EventName::kPowerOffStarted, "the robot is powered off"};
}

RecordText PowerCommandGiven(bool reboot, bool in_time, const std::vector<std::string>& command) {
  std::string line;
  for (const std::string& word : command) line += " " + word;
  return {EventName::kPowerCommandGiven,
          std::string(reboot ? "reboot" : "power-off") +
              (in_time ? "" : ", although the machine is not torn down") +
              (command.empty() ? "; no command is configured" : ":" + line)};
}

RecordText PowerTearDownRefused(const std::string& why) {
  return {EventName::kPowerTearDownRefused, "no TearDown: " + why};
}

}  // namespace musher::texts
