// [policy.*]: the manager's rules.

#include <algorithm>
#include <cmath>
#include <limits>

#include "musher/base/check.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/lifecycle/config/toml/draft.hpp"
#include "musher/lifecycle/config/toml/manager_policy.hpp"
#include "musher/lifecycle/policy/policy.hpp"

namespace musher::config_toml {
namespace {

constexpr double kLongestS = 86'400;  // a day; a longer time is refused as a typing error
constexpr double kShortestS = 0.1;
constexpr int kFull = 100;

const std::vector<std::string_view> kOwnKeys = {"manager", "battery", "low_power", "power_off",
                                                "reboot"};

ManagerPolicyReader manager_reader = nullptr;  // set before main()

std::optional<Duration> ReadSeconds(std::string_view key, TableReader& reader, double least) {
  const auto seconds = reader.Number(key, least, kLongestS);
  if (!seconds) return std::nullopt;
  return Milliseconds(std::llround(*seconds * 1000));
}

std::string ReadTopic(TableReader& reader, const std::string& otherwise) {
  const auto topic = reader.String("topic");
  if (!topic) return otherwise;
  if (topic->text.empty() || !IsNamespace(topic->text)) {
    reader.Fault(topic->at, "topic", "expected a topic's name, found " + Quote(topic->text));
  }
  return topic->text;
}

std::vector<std::string> ReadCommand(TableReader& reader, const Draft& draft) {
  std::vector<std::string> command;
  const auto words = reader.Strings("command", {.may_be_empty = true, .may_repeat = true});
  if (!words || words->empty()) return command;
  for (const Word& word : *words) command.push_back(word.text);
  if (command.front().empty()) {
    reader.Fault(words->front().at, "command", "expected a program, found an empty string");
  } else if (command.front().find('/') != std::string::npos) {
    command.front() = Absolute(draft.folder, command.front());
  }
  return command;
}

class PolicyReader {
 public:
  PolicyReader(const Table& table, Position at, Draft& draft)
      : table_(table), reader_(table, at, "policy", draft.findings), draft_(draft) {}

  PolicyConfig Read() {
    policy_.manager = reader_.Bool("manager").value_or(policy_.manager);
    ReadBattery();
    ReadLowPower();
    ReadPower();
    ReadManager();
    reader_.RefuseOthers();
    return std::move(policy_);
  }

 private:
  void ReadBattery() {
    auto reader = reader_.Sub("battery");
    if (!reader) return;
    BatteryPolicy& battery = policy_.battery.emplace();
    battery.topic = ReadTopic(*reader, battery.topic);
    const auto percent = [&](std::string_view key, int& value) {
      const auto read = reader->Integer(key, 0, kFull, " (percent)");
      if (read) value = static_cast<int>(*read);
      return read || !reader->Has(key);
    };
    const bool protected_read = percent("protected_at", battery.protected_at);
    const bool low_power_read = percent("low_power_at", battery.low_power_at);
    const bool tear_down_read = percent("tear_down_at", battery.tear_down_at);
    const bool hysteresis_read = percent("hysteresis", battery.hysteresis);
    battery.silent = ReadSeconds("silent_s", *reader, kShortestS).value_or(battery.silent);
    battery.tear_down_after =
        ReadSeconds("tear_down_after_s", *reader, 0).value_or(battery.tear_down_after);
    battery.raise_after = ReadSeconds("raise_after_s", *reader, 0).value_or(battery.raise_after);
    reader->RefuseOthers();
    bool ordered = protected_read && low_power_read;
    if (ordered) {
      ordered = CheckOrder(*reader, "low_power_at", battery.low_power_at, "protected_at",
                           battery.protected_at);
    }
    if (low_power_read && tear_down_read) {
      CheckOrder(*reader, "tear_down_at", battery.tear_down_at, "low_power_at",
                 battery.low_power_at);
    }
    if (hysteresis_read) CheckHysteresis(*reader, battery, ordered, protected_read);
    WarnOfMissingStates(*reader);
  }

  static bool CheckOrder(TableReader& reader, std::string_view key, int value,
                         std::string_view above, int limit) {
    if (value < limit) return true;
    const std::string_view at = reader.Has(key) ? key : above;
    reader.Fault(reader.At(at), at,
                 std::string(key) + " (" + std::to_string(value) + ") has to be below " +
                     std::string(above) + " (" + std::to_string(limit) + ")");
    return false;
  }

  // A ceiling that is lifted only at the threshold of the next one, or never, has no effect.
  static void CheckHysteresis(TableReader& reader, const BatteryPolicy& battery, bool ordered,
                              bool protected_read) {
    const auto check = [&](std::string_view key, int at, int limit, const std::string& what) {
      const int left = at + battery.hysteresis;
      if (left <= limit) return;
      const std::string_view where = reader.Has("hysteresis") ? "hysteresis" : key;
      reader.Fault(reader.At(where), where,
                   std::string(key) + " (" + std::to_string(at) + ") plus hysteresis (" +
                       std::to_string(battery.hysteresis) + ") is beyond " + what);
    };
    if (ordered) {
      check("low_power_at", battery.low_power_at, battery.protected_at,
            "protected_at (" + std::to_string(battery.protected_at) + ")");
    }
    if (protected_read) {
      check("protected_at", battery.protected_at, kFull, "100: Protected would never be left");
    }
  }

  void WarnOfMissingStates(TableReader& reader) {
    if (!draft_.states_read) return;
    const auto warn = [&](std::string_view key, const std::string& what) {
      reader.Warn(reader.At(key), key, what);
    };
    const std::pair<std::string_view, BatteryLevel> levels[] = {
        {"protected_at", BatteryLevel::kProtected}, {"low_power_at", BatteryLevel::kLowPower}};
    for (const auto& [key, level] : levels) {
      if (!CeilingState(draft_.config, level).empty()) continue;
      warn(key, "the machine has no state to go down to then");
    }
  }

  void ReadLowPower() {
    auto reader = reader_.Sub("low_power");
    if (!reader) return;
    LowPowerPolicy& low_power = policy_.low_power.emplace();
    low_power.topic = ReadTopic(*reader, low_power.topic);
    low_power.enabled = reader->Bool("enabled").value_or(low_power.enabled);
    low_power.lying_still =
        ReadSeconds("lying_still_s", *reader, kShortestS).value_or(low_power.lying_still);
    if (auto ids = ReadMotionIds(*reader)) low_power.motion_ids = std::move(*ids);
    reader->RefuseOthers();
    if (draft_.states_read && !draft_.listed_states.contains(std::string(kLowPower))) {
      reader_.Fault(reader->at(), "low_power", "\"LowPower\" is not among controller.states");
    }
  }

  static std::optional<std::vector<std::int32_t>> ReadMotionIds(TableReader& reader) {
    const auto ids = reader.Integers("motion_ids", 0, std::numeric_limits<std::int32_t>::max());
    if (!ids) return std::nullopt;
    return std::vector<std::int32_t>(ids->begin(), ids->end());
  }

  void ReadPower() {
    PowerPolicy& power = policy_.power;
    if (auto off = reader_.Sub("power_off")) {
      power.delay = ReadSeconds("delay_s", *off, 0).value_or(power.delay);
      power.force_after = ReadSeconds("force_after_s", *off, 0).value_or(power.force_after);
      power.off_command = ReadCommand(*off, draft_);
      off->RefuseOthers();
      if (power.force_after < power.delay) {
        const std::string_view at = off->Has("force_after_s") ? "force_after_s" : "delay_s";
        off->Fault(off->At(at), at, "force_after_s has to be no less than delay_s");
      }
    }
    if (auto reboot = reader_.Sub("reboot")) {
      power.reboot_command = ReadCommand(*reboot, draft_);
      reboot->RefuseOthers();
    }
  }

  void ReadManager() {
    if (manager_reader != nullptr) return manager_reader(reader_, policy_);
    for (const Member& member : table_) {
      if (reader_.Knows(member.key)) continue;
      // A typing error of a key above is none of a manager's keys.
      if (!draft_.findings.Guess(member.key, kOwnKeys).empty()) continue;
      reader_.Get(member.key);
      policy_.unread_keys.push_back("policy." + member.key);
    }
  }

  const Table& table_;
  TableReader reader_;
  Draft& draft_;
  PolicyConfig policy_;
};

}  // namespace

bool RegisterManagerPolicyReader(ManagerPolicyReader reader) {
  MUSHER_CHECK(manager_reader == nullptr || manager_reader == reader,
               "a program has one manager at most");
  manager_reader = reader;
  return true;
}

void ReadPolicy(TableReader& root, Draft& draft) {
  const Table* table = root.SubTable("policy");
  if (table == nullptr) return;
  draft.config.policy = PolicyReader(*table, root.At("policy"), draft).Read();
}

}  // namespace musher::config_toml
