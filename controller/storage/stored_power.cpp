#include "musher/controller/storage/stored_power.hpp"

#include <cstdint>
#include <sstream>
#include <string_view>

#include "musher/base/host.hpp"
#include "musher/controller/process/host_uptime.hpp"
#include "musher/controller/storage/slot_file.hpp"
#include "musher/controller/storage/state_store.hpp"

namespace musher {
namespace {

constexpr std::string_view kPowerWord = "power";
constexpr std::string_view kPowerOffWord = "off";
constexpr std::string_view kRebootWord = "reboot";

struct StoredPower {
  PowerAhead ahead = PowerAhead::kNone;
  std::string boot;  // of the computer; empty: an earlier version has stored it
  std::int64_t decided_ms = 0;
};

std::string PresentBoot() {
  const std::string host = HostId();
  const std::string boot = host.substr(0, host.find('/'));
  return boot.empty() ? "-" : boot;
}

StoredPower StoredIn(const std::string& policy) {
  std::istringstream lines(policy);
  StoredPower power;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    if (!(words >> word) || word != kPowerWord || !(words >> word)) continue;
    if (word == kPowerOffWord) power.ahead = PowerAhead::kOff;
    if (word == kRebootWord) power.ahead = PowerAhead::kReboot;
    if (!(words >> power.boot >> power.decided_ms)) power.boot.clear();
  }
  return power;
}

std::string WhyForgotten(const StoredPower& power) {
  if (power.ahead == PowerAhead::kNone) return "";
  const std::string what = power.ahead == PowerAhead::kReboot ? "a reboot" : "a power-off";
  if (power.boot.empty()) {
    return what + " that an earlier version has stored is forgotten: its time is not known";
  }
  if (power.boot != PresentBoot()) {
    return what + " that was decided before this computer was booted is forgotten";
  }
  const Duration age = SinceBoot() - Milliseconds(power.decided_ms);
  if (age >= Duration() && age <= kPowerKept) return "";
  const auto minutes = std::chrono::duration_cast<std::chrono::minutes>(age).count();
  const auto limit = std::chrono::duration_cast<std::chrono::minutes>(kPowerKept).count();
  return what + " that was decided " + std::to_string(minutes) +
         " min ago is forgotten: it outlasts its controller for " + std::to_string(limit) + " min";
}

}  // namespace

std::string PowerLine(PowerAhead ahead, const std::string& stored) {
  StoredPower power = StoredIn(stored);
  if (power.ahead != ahead || !WhyForgotten(power).empty()) {
    power = {ahead, PresentBoot(), ToMilliseconds(SinceBoot())};
  }
  const std::string_view word = ahead == PowerAhead::kReboot ? kRebootWord : kPowerOffWord;
  return std::string(kPowerWord) + " " + std::string(word) + " " + power.boot + " " +
         std::to_string(power.decided_ms) + "\n";
}

PowerAhead PowerIn(const std::string& policy) {
  const StoredPower power = StoredIn(policy);
  return WhyForgotten(power).empty() ? power.ahead : PowerAhead::kNone;
}

std::string WhyPowerForgottenIn(const std::string& state_dir) {
  const auto policy = SlotFile(StateStore::PolicyFileIn(state_dir), SlotFile::kShortSlot).Read();
  return WhyForgotten(StoredIn(policy ? policy->text : ""));
}

}  // namespace musher
