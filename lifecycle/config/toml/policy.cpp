// [policy.*]: the manager's rules.

#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/base/toml/rows.hpp"
#include "musher/lifecycle/config/toml/draft.hpp"
#include "musher/lifecycle/config/toml/manager_policy.hpp"
#include "musher/lifecycle/policy/policy.hpp"

namespace musher::config_toml {
namespace {

constexpr int kFull = 100;

const std::vector<std::string_view> kOwnKeys = {"manager", "battery", "low_power", "power_off",
                                                "reboot"};

ManagerPolicyReader manager_reader = nullptr;  // set before main()

// Makes a row of each key of a policy.
class PolicyRows {
 public:
  explicit PolicyRows(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void Topic(std::string_view key, std::string& topic) {
    rows.push_back(row::Topic(key, topic, "bms_status", {.relative = true}));
  }
  void Percent(std::string_view key, int& percent) {
    rows.push_back(row::Integer(key, percent, 0, kFull, " (percent)"));
  }
  void Seconds(std::string_view key, Duration& time, double least) {
    constexpr double kLongestS = 86'400;  // a day; a longer time is refused as a typing error
    rows.push_back([key, &time, least](TableReader& reader) {
      const auto seconds = reader.Number(key, least, kLongestS);
      if (seconds) time = Milliseconds(std::llround(*seconds * 1000));
    });
  }
  void Bool(std::string_view key, bool& value) { rows.push_back(row::Bool(key, value)); }
  void Set(std::string_view key, std::vector<std::int32_t>& numbers) {
    rows.push_back([key, &numbers](TableReader& reader) {
      const auto read = reader.Integers(key, 0, std::numeric_limits<std::int32_t>::max());
      if (read) numbers.assign(read->begin(), read->end());
    });
  }
  void Program(std::string_view key, std::vector<std::string>& argv) {
    rows.push_back(row::Program(key, argv, folder_, {.may_be_empty = true, .may_repeat = true}));
  }

  Rows rows;

 private:
  const std::filesystem::path folder_;
};

bool CheckOrder(TableReader& reader, std::string_view key, int value, std::string_view above,
                int limit) {
  if (value < limit) return true;
  const std::string_view at = reader.Has(key) ? key : above;
  reader.Fault(reader.At(at), at,
               std::string(key) + " (" + std::to_string(value) + ") has to be below " +
                   std::string(above) + " (" + std::to_string(limit) + ")");
  return false;
}

// A ceiling that is lifted only at the threshold of the next one, or never, has no effect.
void CheckHysteresis(TableReader& reader, const BatteryPolicy& battery, bool ordered,
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

void CheckBattery(TableReader& reader, const BatteryPolicy& battery) {
  const bool protected_read = !reader.IsFaulty("protected_at");
  const bool low_power_read = !reader.IsFaulty("low_power_at");
  const bool tear_down_read = !reader.IsFaulty("tear_down_at");
  const bool hysteresis_read = !reader.IsFaulty("hysteresis");
  const bool ordered = protected_read && low_power_read &&
                       CheckOrder(reader, "low_power_at", battery.low_power_at, "protected_at",
                                  battery.protected_at);
  if (low_power_read && tear_down_read) {
    CheckOrder(reader, "tear_down_at", battery.tear_down_at, "low_power_at", battery.low_power_at);
  }
  if (hysteresis_read) CheckHysteresis(reader, battery, ordered, protected_read);
}

void WarnOfMissingStates(TableReader& reader, const Draft& draft) {
  if (!draft.states_read) return;
  const std::pair<std::string_view, BatteryLevel> levels[] = {
      {"protected_at", BatteryLevel::kProtected}, {"low_power_at", BatteryLevel::kLowPower}};
  for (const auto& [key, level] : levels) {
    if (!CeilingState(draft.config, level).empty()) continue;
    reader.Warn(reader.At(key), key, "the machine has no state to go down to then");
  }
}

void CheckPowerOff(TableReader& off, const PowerPolicy& power) {
  if (power.force_after >= power.delay) return;
  const std::string_view at = off.Has("force_after_s") ? "force_after_s" : "delay_s";
  off.Fault(off.At(at), at, "force_after_s has to be no less than delay_s");
}

class PolicyReader {
 public:
  PolicyReader(const Table& table, Position at, Draft& draft)
      : table_(table), reader_(table, at, "policy", draft.findings), draft_(draft) {}

  PolicyConfig Read() {
    ReadRows(reader_, {row::Bool("manager", policy_.manager),
                       [this](TableReader& policy) { ReadBattery(policy); },
                       [this](TableReader& policy) { ReadLowPower(policy); },
                       [this](TableReader& policy) { ReadPower(policy); },
                       [this](TableReader& policy) { ReadManager(policy); }});
    return std::move(policy_);
  }

 private:
  void ReadBattery(TableReader& policy) {
    auto reader = policy.Sub("battery");
    if (!reader) return;
    BatteryPolicy& battery = policy_.battery.emplace();
    PolicyRows keys(draft_.folder);
    BatteryPolicy::Keys(battery, keys);
    ReadRows(*reader, keys.rows);
    CheckBattery(*reader, battery);
    WarnOfMissingStates(*reader, draft_);
  }

  void ReadLowPower(TableReader& policy) {
    auto reader = policy.Sub("low_power");
    if (!reader) return;
    PolicyRows keys(draft_.folder);
    LowPowerPolicy::Keys(policy_.low_power.emplace(), keys);
    ReadRows(*reader, keys.rows);
    if (draft_.states_read && !draft_.listed_states.contains(std::string(kLowPower))) {
      policy.Fault(reader->at(), "low_power", "\"LowPower\" is not among controller.states");
    }
  }

  void ReadPower(TableReader& policy) {
    if (auto off = policy.Sub("power_off")) {
      PolicyRows keys(draft_.folder);
      PowerPolicy::OffKeys(policy_.power, keys);
      ReadRows(*off, keys.rows);
      CheckPowerOff(*off, policy_.power);
    }
    if (auto reboot = policy.Sub("reboot")) {
      PolicyRows keys(draft_.folder);
      PowerPolicy::RebootKeys(policy_.power, keys);
      ReadRows(*reboot, keys.rows);
    }
  }

  void ReadManager(TableReader& policy) {
    if (manager_reader != nullptr) return manager_reader(policy, policy_);
    for (const Member& member : table_) {
      if (policy.Knows(member.key)) continue;
      // A typing error of a key above is none of a manager's keys.
      if (!draft_.findings.Guess(member.key, kOwnKeys).empty()) continue;
      policy.Get(member.key);
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
