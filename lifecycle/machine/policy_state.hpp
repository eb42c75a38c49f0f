#pragma once
// The state of the policy (battery, lying still, keep, power). Plain values; the rules are in
// policy/ and rules/.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/field.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher {

// The lower the battery, the higher the value.
enum class BatteryLevel {
  kFree,       // no limit
  kProtected,  // at most Protected
  kLowPower,   // at most LowPower
  kEmpty,      // the machine is torn down, the robot is powered off
};
std::string_view LevelName(BatteryLevel level);  // "free", "protected", "low power", "empty"

// What a person, an application or the robot's own buttons request from the policy.
enum class PolicyRequest {
  kSwitch,          // to `state`, directly
  kKeep,            // to `state`, and stay there for `ticks` seconds; 0: end of that, or no stay
  kOta,             // `enable`: into OTA, else out of it
  kLowPowerSwitch,  // `enable` for this run
  kLowPowerStore,   // the same, stored on disk
  kWakeUp,          // out of LowPower
  kPowerOff,
  kReboot,
};
std::string_view RequestName(PolicyRequest request);  // "switch", "keep", … as on the wire
std::optional<PolicyRequest> RequestOf(std::string_view name);
// Whether it wakes up a machine that is in LowPower: "automatic LowPower: off" does, too.
bool WakesUp(PolicyRequest request, bool enable);

// What the policy subscribes to.
enum class PolicyInput { kBattery, kMotion };

// The state to which the battery rule took the machine, and the state before, to which it returns.
// Survives the controller, unless another one has led meanwhile.
struct BatteryFallback {
  State from;
  State to;
  Epoch epoch = 0;  // of the controller that stored it

  friend bool operator==(const BatteryFallback&, const BatteryFallback&) = default;
};

// A power-off that is accepted and not commanded yet: a controller that its supervisor restarts
// goes on with it. A boot and a person's start end it.
enum class PowerAhead { kNone, kOff, kReboot };

// What has to survive the controller.
struct StoredPolicy {
  std::optional<bool> low_power;  // the LowPower switch, once it was stored
  std::optional<BatteryFallback> lowering;
  BatteryLevel level = BatteryLevel::kFree;  // the last known, at most LowPower
  PowerAhead power = PowerAhead::kNone;

  friend bool operator==(const StoredPolicy&, const StoredPolicy&) = default;
};

// The machine is kept in a state for a while.
struct Keep {
  State state;
  std::int64_t seconds = 0;
  Time until{};                     // by the policy's clock
  CommandNumber switch_number = 0;  // of the switch to it; if that is undone, the keep ends

  friend bool operator==(const Keep&, const Keep&) = default;
};

// The robot is about to be powered off. Always by the steady clock: this powers off the real robot.
struct PowerDown {
  bool reboot = false;
  Time tear_down_at{};
  Time force_at{};
  bool commanded = false;  // the command has been given
  RecordId cause = 0;      // the record with the reason
  std::string by;          // as in Requester

  friend bool operator==(const PowerDown&, const PowerDown&) = default;
};

// So many samples in a row confirm what one sample may not decide.
inline constexpr int kConfirmingSamples = 3;

// The last sample of one publisher of the battery.
struct BatterySource {
  std::uint32_t source = 0;
  std::int32_t percent = 0;
  bool charging = false;

  friend bool operator==(const BatterySource&, const BatterySource&) = default;
};

// Samples in a row that allow a level, by the steady clock.
struct LevelRun {
  BatteryLevel level = BatteryLevel::kFree;  // the lowest level of these samples
  Time since{};
  int samples = 0;
  int higher = 0;  // how many samples at the end allow a higher level

  friend bool operator==(const LevelRun&, const LevelRun&) = default;
};

struct PolicyState {
  Time clock{};         // the last time received from /clock, where the policy follows it
  bool loaded = false;  // all stages have been up, or given up: the battery rules begin

  std::vector<BatterySource> batteries;  // the last to report stands last
  std::optional<int> battery;            // in percent, the lowest of `batteries`
  bool charging = false;                 // all of `batteries` report it
  bool battery_silent = false;
  bool invalid_recorded = false;             // an out-of-range value was recorded
  bool jump_recorded = false;                // a change that no battery can make was recorded
  bool doubled_recorded = false;             // several publishers were recorded
  BatteryLevel level = BatteryLevel::kFree;  // sets the ceiling; without samples the stored one
  RecordId level_cause = 0;                  // the record of the level
  std::optional<LevelRun> lifting;           // samples that would lift the ceiling to their level
  std::optional<LevelRun> emptying;          // samples that report the battery empty
  bool empty = false;                        // confirmed: the robot is powered off

  StoredPolicy stored;
  std::optional<BatteryFallback> withheld;  // the higher state that the battery does not allow yet
  bool low_power = false;                   // the LowPower switch
  bool still = false;                       // the robot lies still
  std::optional<Time> still_since;          // since when it lies still
  std::optional<Keep> keep;
  std::optional<PowerDown> power;

  int failures = 0;              // of switches of the policy in a row
  std::optional<Time> retry_at;  // by the steady clock
  std::vector<RequestId> calls;  // requests that wait for the end of a switch

  friend bool operator==(const PolicyState&, const PolicyState&) = default;
};

// The time by the clock of the policy.
Time PolicyNow(const MachineConfig& config, const PolicyState& policy, Time now);

}  // namespace musher

namespace musher::fields {

template <>
inline constexpr std::array<std::string_view, 3> kValueNames<PowerAhead> = {"none", "off",
                                                                            "reboot"};
static_assert(EndsWith(PowerAhead::kReboot));

template <>
inline constexpr std::array<std::string_view, 2> kValueNames<PolicyInput> = {"battery", "motion"};
static_assert(EndsWith(PolicyInput::kMotion));

template <>
inline constexpr std::array<std::string_view, 4> kValueNames<BatteryLevel> = {"free", "protected",
                                                                              "low-power", "empty"};
static_assert(EndsWith(BatteryLevel::kEmpty));

template <>
inline constexpr std::array<std::string_view, 8> kValueNames<PolicyRequest> = {
    "switch",          "keep",    "OTA",       "low-power switch",
    "low-power store", "wake-up", "power-off", "reboot"};
static_assert(EndsWith(PolicyRequest::kReboot));

template <>
inline constexpr std::tuple kFields<BatteryFallback> = {Field{"from", &BatteryFallback::from},
                                                        Field{"to", &BatteryFallback::to},
                                                        Field{"epoch", &BatteryFallback::epoch}};

template <>
inline constexpr std::tuple kFields<StoredPolicy> = {
    Field{"low_power", &StoredPolicy::low_power},
    Field{"lowering", &StoredPolicy::lowering},
    Field{"level", &StoredPolicy::level},
    Field{"power", &StoredPolicy::power},
};

template <>
inline constexpr std::tuple kFields<Keep> = {
    Field{"state", &Keep::state},
    Field{"seconds", &Keep::seconds},
    Field{"until", &Keep::until},
    Field{"switch_number", &Keep::switch_number},
};

template <>
inline constexpr std::tuple kFields<PowerDown> = {
    Field{"reboot", &PowerDown::reboot},     Field{"tear_down_at", &PowerDown::tear_down_at},
    Field{"force_at", &PowerDown::force_at}, Field{"commanded", &PowerDown::commanded},
    Field{"cause", &PowerDown::cause},       Field{"by", &PowerDown::by},
};

template <>
inline constexpr std::tuple kFields<BatterySource> = {
    Field{"source", &BatterySource::source},
    Field{"percent", &BatterySource::percent},
    Field{"charging", &BatterySource::charging},
};

template <>
inline constexpr std::tuple kFields<LevelRun> = {
    Field{"level", &LevelRun::level},
    Field{"since", &LevelRun::since},
    Field{"samples", &LevelRun::samples},
    Field{"higher", &LevelRun::higher},
};

template <>
inline constexpr std::tuple kFields<PolicyState> = {
    Field{"clock", &PolicyState::clock},
    Field{"loaded", &PolicyState::loaded},
    Field{"batteries", &PolicyState::batteries},
    Field{"battery", &PolicyState::battery},
    Field{"charging", &PolicyState::charging},
    Field{"battery_silent", &PolicyState::battery_silent},
    Field{"invalid_recorded", &PolicyState::invalid_recorded},
    Field{"jump_recorded", &PolicyState::jump_recorded},
    Field{"doubled_recorded", &PolicyState::doubled_recorded},
    Field{"level", &PolicyState::level},
    Field{"level_cause", &PolicyState::level_cause},
    Field{"lifting", &PolicyState::lifting},
    Field{"emptying", &PolicyState::emptying},
    Field{"empty", &PolicyState::empty},
    Field{"stored", &PolicyState::stored},
    Field{"withheld", &PolicyState::withheld},
    Field{"low_power", &PolicyState::low_power},
    Field{"still", &PolicyState::still},
    Field{"still_since", &PolicyState::still_since},
    Field{"keep", &PolicyState::keep},
    Field{"power", &PolicyState::power},
    Field{"failures", &PolicyState::failures},
    Field{"retry_at", &PolicyState::retry_at},
    Field{"calls", &PolicyState::calls},
};

}  // namespace musher::fields
