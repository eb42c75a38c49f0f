// Sentences about the policy: the battery, lying still, keep and power-off.

#include <chrono>

#include "musher/lifecycle/record/texts.hpp"

namespace musher::texts {
namespace {

std::int64_t ToSeconds(Duration duration) {
  return std::chrono::duration_cast<std::chrono::seconds>(duration).count();
}

std::string LimitForm(BatteryLimit limit) {
  switch (limit) {
    case BatteryLimit::kAsBefore:
      return "";
    case BatteryLimit::kLifted:
      return ": the machine is no longer limited";
    case BatteryLimit::kNoSwitchAbove:
      return ": no switch above {most}";
    case BatteryLimit::kEmpty:
      return ": it is empty";
    case BatteryLimit::kLimited:
      break;
  }
  return ": the machine is limited to {most}";
}

}  // namespace

RecordText PolicyRequested(const std::string& what, const State& target, const std::string& by) {
  return MakeText(EventName::kPolicyRequested,
                  by.empty() ? "{what} requested" : "{what} requested by {by}",
                  {{"what", what}, {"target", target}, {"by", by}});
}

RecordText PolicyRefused(const std::string& what, const std::string& why) {
  return MakeText(EventName::kPolicyRefused, "{what} refused: {reason}",
                  {{"what", what}, {"reason", why}});
}

RecordText BatterySampleInvalid(int percent) {
  return MakeText(EventName::kBatterySampleInvalid,
                  "the battery reports {percent} %, which is out of range; such values are ignored",
                  {{"percent", percent}});
}

RecordText BatteryJumped(int before, int percent) {
  return MakeText(EventName::kBatteryJumped,
                  "the battery reports {percent} % after {before} %: impossible between two "
                  "samples; check the publisher",
                  {{"percent", percent}, {"before", before}});
}

RecordText BatteryDoubled(const std::string& topic, int publishers, int lowest, int highest) {
  return MakeText(
      EventName::kBatteryDoubled,
      "{publishers} programs publish {topic}, {lowest} to {highest} %; the lowest "
      "counts, stop all but one",
      {{"publishers", publishers}, {"topic", topic}, {"lowest", lowest}, {"highest", highest}});
}

RecordText BatterySilent(Duration limit, std::optional<int> last, bool was_low) {
  std::string effect = "its level is unknown";
  if (last) {
    effect = "its last value, {percent} %, stays in effect";
  } else if (was_low) {
    effect = "it was low before the start, which stays in effect";
  }
  return MakeText(EventName::kBatterySilent, "no battery sample for {limit_s} s; " + effect,
                  {{"limit_s", ToSeconds(limit)}, {"percent", last}});
}

RecordText BatteryResumed() {
  return {EventName::kBatteryResumed, "battery samples received again"};
}

std::string BatteryText(std::optional<int> percent, bool charging) {
  if (!percent) return "the battery was low, and has sent no sample since";
  return "the battery is at " + std::to_string(*percent) + " %" +
         (charging ? ", being charged" : "");
}

RecordText BatteryChanged(int percent, bool charging, std::optional<bool> charger,
                          BatteryLimit limit, const State& most) {
  const EventName of_charger =
      charger.value_or(false) ? EventName::kChargerConnected : EventName::kChargerDisconnected;
  const bool names_most = limit == BatteryLimit::kNoSwitchAbove || limit == BatteryLimit::kLimited;
  std::string change;
  if (charger) change = *charger ? "connected" : "disconnected";
  return MakeText(
      limit == BatteryLimit::kAsBefore ? of_charger : EventName::kBatteryLevelChanged,
      BatteryText(percent, charging) + (charger ? ": charger {charger}" : "") + LimitForm(limit),
      {{"percent", percent},
       {"charging", charging},
       {"charger", change},
       {"most", names_most ? most : State()}});
}

RecordText BatteryLimitsStart(const std::string& limit, const State& target) {
  return MakeText(
      EventName::kBatteryLimitsStart,
      "{limit}; the start ends in {target}, and goes on by itself as far as the battery allows",
      {{"limit", limit}, {"target", target}});
}

RecordText BatterySwitchDown(std::optional<int> percent, bool charging, const State& target) {
  return MakeText(EventName::kBatterySwitchDown,
                  BatteryText(percent, charging) + ": down to {target}",
                  {{"percent", percent}, {"charging", charging}, {"target", target}});
}

RecordText BatterySwitchUp(int percent, bool charging, const State& target) {
  return MakeText(EventName::kBatterySwitchUp, BatteryText(percent, charging) + ": up to {target}",
                  {{"percent", percent}, {"charging", charging}, {"target", target}});
}

RecordText LyingStill(Duration limit) {
  return MakeText(EventName::kLyingStillSwitch,
                  "the robot has lain still for {limit_s} s: down to {target}",
                  {{"limit_s", ToSeconds(limit)}, {"target", State(kLowPower)}});
}

RecordText PolicySwitchRefused(const RecordText& wanted, const std::string& why) {
  return MakeText(EventName::kPolicySwitchRefused, "{switch} refused: {reason}",
                  {{"switch", wanted.message},
                   {"target", ArgumentOf(wanted.arguments, "target")},
                   {"reason", why}});
}

RecordText KeepEnded(const State& state, const std::string& why) {
  return MakeText(EventName::kKeepEnded, "the machine is no longer kept in {state}: {reason}",
                  {{"state", state}, {"reason", why}});
}

RecordText PowerDownStarted(bool reboot) {
  if (reboot) return {EventName::kRebootStarted, "the robot reboots"};
  return {EventName::kPowerOffStarted, "the robot is powered off"};
}

RecordText PowerCommandGiven(bool reboot, bool in_time, const std::vector<std::string>& command) {
  std::string line;
  for (const std::string& word : command) line += (line.empty() ? "" : " ") + word;
  return MakeText(EventName::kPowerCommandGiven,
                  std::string("{what}") +
                      (in_time ? "" : ", although the machine is not torn down") +
                      (command.empty() ? "; no command is configured" : ": {command}"),
                  {{"what", reboot ? "reboot" : "power-off"}, {"command", line}});
}

RecordText PowerCommandFailed(const std::string& command, const std::string& how) {
  return MakeText(EventName::kPowerCommandFailed, "the command of {command} {how}",
                  {{"command", command}, {"how", how}});
}

RecordText PowerTearDownRefused(const std::string& why) {
  return MakeText(EventName::kPowerTearDownRefused, "no TearDown: {reason}", {{"reason", why}});
}

}  // namespace musher::texts
