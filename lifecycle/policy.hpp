#pragma once
// The manager's rules (battery, lying still, keep, power): what they remember, and the parts of
// them that need nothing but a number. The rules themselves are part of Step(): policy_rules.cpp,
// policy_requests.cpp, power.cpp.
//
// The battery sets a ceiling. It is a level and not a crossing: whatever the percentage was before,
// the machine may be no more active than the present one allows, so a jump misses nothing.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/lifecycle/time.hpp"

namespace musher {

struct Machine;

// The lower the battery, the higher the value.
enum class BatteryLevel {
  kFree,       // no ceiling
  kProtected,  // at most Protected
  kLowPower,   // at most LowPower
  kEmpty,      // the machine is torn down, the robot is powered off
};
std::string_view LevelName(BatteryLevel level);  // "free", "protected", "low power", "empty"

// The level of `percent`, coming from `before`. Protected and LowPower are left only `hysteresis`
// above where they begin. Empty has none: it ends the machine, or a cable has kept it from that.
BatteryLevel LevelAt(const BatteryPolicy& policy, int percent, BatteryLevel before);

// The rank that `level` allows at most; nullopt: any.
std::optional<Rank> CeilingRank(BatteryLevel level);

// Where a machine under that ceiling is to be: the most active of its states that the ceiling
// allows, at most Active, and without Error and OTA, which say something else. Empty: it has none.
State CeilingState(const MachineConfig& config, BatteryLevel level);

// What is asked of the policy by a person, an application or the robot's own buttons.
enum class PolicyRequest {
  kSwitch,          // to `state`, directly
  kKeep,            // to `state`, and stay there for `ticks` seconds; 0: end of that, or no stay
  kOta,             // `enable`: into OTA, else out of it
  kLowPowerSwitch,  // `enable` for this run
  kLowPowerStore,   // the same, for ever
  kWakeUp,          // out of LowPower
  kPowerOff,
  kReboot,
};
std::string_view RequestName(PolicyRequest request);  // "switch", "keep", … as on the wire
std::optional<PolicyRequest> RequestOf(std::string_view name);

// What the policy listens to.
enum class PolicyInput { kBattery, kMotion };

// Where the battery has taken the machine, and from where: there it is brought back. Survives the
// controller, unless another one has led meanwhile.
struct Lowering {
  State from;
  State to;
  std::uint64_t epoch = 0;  // of the controller that remembers it

  friend bool operator==(const Lowering&, const Lowering&) = default;
};

// What has to survive the controller.
struct StoredPolicy {
  std::optional<bool> low_power;  // the switch, once somebody has stored it
  std::optional<Lowering> lowering;

  friend bool operator==(const StoredPolicy&, const StoredPolicy&) = default;
};

// The machine is kept in a state for a while.
struct Keep {
  State state;
  std::int64_t seconds = 0;
  Time until{};                     // by the policy's clock
  std::uint64_t switch_number = 0;  // that leads there; undone, it ends the keep

  friend bool operator==(const Keep&, const Keep&) = default;
};

// The robot is about to lose its power. Always by the steady clock: this is the real robot's end.
struct PowerDown {
  bool reboot = false;
  Time tear_down_at{};
  Time force_at{};
  bool commanded = false;   // the command has been given
  std::uint64_t cause = 0;  // the record that says why

  friend bool operator==(const PowerDown&, const PowerDown&) = default;
};

struct PolicyState {
  Time clock{};         // the last time heard from /clock, where the policy follows it
  bool loaded = false;  // all stages have been up, or given up: the battery's rules begin

  std::optional<int> battery;  // in percent, the last valid one
  bool charging = false;
  bool battery_silent = false;
  bool invalid_told = false;  // that a value was out of range
  BatteryLevel level = BatteryLevel::kFree;
  std::uint64_t level_cause = 0;  // the record of the level

  StoredPolicy stored;
  std::optional<Lowering> withheld;  // what the battery keeps the switch under way from
  bool low_power = false;            // the switch
  bool still = false;                // the robot lies still
  std::optional<Time> still_since;   // counting towards LowPower
  std::optional<Keep> keep;
  std::optional<PowerDown> power;

  int failures = 0;                  // of switches of the policy in a row
  std::optional<Time> retry_at;      // by the steady clock
  std::vector<std::uint64_t> calls;  // requests that wait for the end of a switch

  friend bool operator==(const PolicyState&, const PolicyState&) = default;
};

// The level that takes the machine down: while it is charged it is not taken below Protected.
BatteryLevel TakingDownLevel(const PolicyState& policy);

// "the battery is at 4 %, and not charged"
std::string BatteryText(const PolicyState& policy);

// Why nothing goes above the ceiling of `level`, with the numbers and the way out.
Error AboveCeiling(const MachineConfig& config, const PolicyState& policy, BatteryLevel level);

// Why the policy does not let the machine switch to `target`, with what would change that. Down is
// always allowed.
std::optional<Error> RefusalByPolicy(const MachineConfig& config, const Machine& machine,
                                     const State& target);

// The time that the policy goes by.
Time PolicyNow(const MachineConfig& config, const PolicyState& policy, Time now);

}  // namespace musher
