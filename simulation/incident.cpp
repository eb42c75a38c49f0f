#include "musher/simulation/incident.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "musher/simulation/hosts.hpp"
#include "musher/transport/sim/random.hpp"

namespace musher::simulation {
namespace {

using transport::sim::Random;

struct KindRow {
  IncidentKind kind;
  std::string_view name;
  int weight;  // how often it is drawn
};

constexpr std::array<KindRow, kIncidentKinds> kKinds = {{
    {IncidentKind::kCrash, "crash", 9},
    {IncidentKind::kWrongConfig, "wrong-config", 0},  // some of the crashes are one
    {IncidentKind::kFreeze, "freeze", 4},
    {IncidentKind::kHang, "hang", 4},
    {IncidentKind::kSlow, "slow", 4},
    {IncidentKind::kFail, "fail", 5},
    {IncidentKind::kLie, "lie", 2},
    {IncidentKind::kLoss, "loss", 3},
    {IncidentKind::kDelay, "delay", 3},
    {IncidentKind::kDuplication, "duplication", 3},
    {IncidentKind::kReordering, "reordering", 3},
    {IncidentKind::kPartition, "partition", 3},
    {IncidentKind::kDeaf, "deaf", 2},
    {IncidentKind::kMute, "mute", 2},
    {IncidentKind::kControllerCrash, "controller-crash", 4},
    {IncidentKind::kControllerFreeze, "controller-freeze", 2},
    {IncidentKind::kRival, "rival", 1},
    {IncidentKind::kTakeover, "takeover", 1},
    {IncidentKind::kFullDisk, "full-disk", 2},
    {IncidentKind::kWallClock, "wall-clock", 1},
    {IncidentKind::kSet, "set", 34},
    {IncidentKind::kSetOne, "set-one", 4},
    {IncidentKind::kBattery, "battery", 4},
    {IncidentKind::kEmergencyStop, "emergency-stop", 3},
    {IncidentKind::kRelease, "release", 4},
    {IncidentKind::kRestart, "restart", 2},
    // These have dice of their own.
    {IncidentKind::kStillness, "stillness", 0},
    {IncidentKind::kWakeUp, "wake-up", 0},
    {IncidentKind::kKeep, "keep", 0},
    {IncidentKind::kOta, "ota", 0},
    {IncidentKind::kLowPowerSwitch, "low-power-switch", 0},
    {IncidentKind::kPowerOff, "power-off", 0},
    {IncidentKind::kReboot, "reboot", 0},
    {IncidentKind::kHostPartition, "host-partition", 0},
    {IncidentKind::kHostOneWay, "host-one-way", 0},
    {IncidentKind::kStalledDisk, "stalled-disk", 0},
    {IncidentKind::kCrossingStops, "crossing-stops", 0},
    {IncidentKind::kClientSet, "client-set", 0},
    {IncidentKind::kClientStatus, "client-status", 0},
    {IncidentKind::kClientRelease, "client-release", 0},
    {IncidentKind::kClientRestart, "client-restart", 0},
}};

// How often what makes a process end is its configuration.
constexpr double kWrongConfigShare = 0.2;

// How often a robot with a policy meets something that concerns it, and what.
constexpr double kPolicyShare = 0.4;
constexpr IncidentKind kOfPolicy[] = {
    IncidentKind::kBattery,        IncidentKind::kBattery,   IncidentKind::kBattery,
    IncidentKind::kBattery,        IncidentKind::kStillness, IncidentKind::kStillness,
    IncidentKind::kWakeUp,         IncidentKind::kKeep,      IncidentKind::kOta,
    IncidentKind::kLowPowerSwitch, IncidentKind::kPowerOff};
constexpr int kFull = 100;

// How often something happens to a host instead of a single process.
constexpr double kHostShare = 0.03;
constexpr double kSeveralHostsShare = 0.15;
// How often a client does something at the same time as well, and what.
constexpr double kClientShare = 0.2;
constexpr double kOrphanShare = 0.6;
constexpr IncidentKind kOfClients[] = {IncidentKind::kClientSet,     IncidentKind::kClientSet,
                                       IncidentKind::kClientStatus,  IncidentKind::kClientStatus,
                                       IncidentKind::kClientRelease, IncidentKind::kClientRestart};
constexpr IncidentKind kOfHosts[] = {IncidentKind::kHostPartition, IncidentKind::kHostOneWay,
                                     IncidentKind::kHostOneWay, IncidentKind::kReboot};

// Where the levels are, everything happens; and at the ends.
int DrawPercent(const MachineConfig& config, std::uint64_t chance) {
  const BatteryPolicy battery = config.policy->battery.value_or(BatteryPolicy{});
  const int near[] = {battery.tear_down_at, battery.low_power_at, battery.protected_at};
  const auto spread = static_cast<int>(chance / 8 % 8) - 3;
  switch (chance % 8) {
    case 0:
      return static_cast<int>(chance / 8 % (kFull + 1));
    case 1:
      return kFull;
    case 2:
      return std::clamp(near[0] + spread, 0, kFull);
    case 3:
    case 4:
      return std::clamp(near[1] + spread, 1, kFull);
    default:
      return std::clamp(near[2] + spread, 1, kFull);
  }
}

constexpr std::uint64_t kAllWeights = std::accumulate(
    kKinds.begin(), kKinds.end(), std::uint64_t{0}, [](std::uint64_t sum, const KindRow& row) {
      return sum + static_cast<std::uint64_t>(row.weight);
    });

const KindRow& RowOf(IncidentKind kind) {
  return kKinds[static_cast<std::size_t>(kind)];
}

IncidentKind DrawKind(Random& dice) {
  int left = static_cast<int>(dice.Next() % kAllWeights);
  for (const KindRow& row : kKinds) {
    left -= row.weight;
    if (left < 0) return row.kind;
  }
  return IncidentKind::kSet;
}

// As likely between 1 and 10 ms as between 1 and 10 s.
Duration DrawLogUniform(Random& dice, Duration least, Duration most) {
  constexpr double kUnit = 1.0 / 9007199254740992.0;  // 2^-53
  const double share = static_cast<double>(dice.Next() >> 11) * kUnit;
  const double ratio = static_cast<double>(most.count()) / static_cast<double>(least.count());
  return Duration(
      static_cast<Duration::rep>(static_cast<double>(least.count()) * std::pow(ratio, share)));
}

// The states that can be asked for; a TearDown, after which little happens, is rare.
State DrawState(const MachineConfig& config, Random& dice) {
  std::vector<State> states;
  for (const State& state : config.states) {
    if (state == kSetUp || state == kTearDown) continue;
    states.push_back(state);
  }
  if (states.empty() || (config.HasState(kTearDown) && dice.Chance(0.02))) return State(kTearDown);
  return states[dice.Next() % states.size()];
}

// The moments that few would meet by chance, and what leads to them.
class Drawing {
 public:
  Drawing(const MachineConfig& config, std::uint64_t seed)
      : config_(config),
        dice_(seed * 2 + 1),
        policy_dice_(seed * 2 + 0x706f6c),
        exit_dice_(seed * 2 + 0x65786974),
        host_dice_(seed * 2 + 0x72656274),
        hosts_(DrawLayout(config, seed, false).hosts.size()) {}

  Incidents Draw() {
    const std::uint64_t count = 1 + dice_.Next() % (1 + dice_.Next() % 16);
    for (std::uint64_t i = 0; i < count; ++i) {
      const bool crash =
          !incidents_.empty() && incidents_.back().kind == IncidentKind::kControllerCrash;
      if (crash && host_dice_.Chance(kOrphanShare)) AddOrphan();
      if (!incidents_.empty() && host_dice_.Chance(kClientShare)) AddOfClient();
      at_ += DrawLogUniform(dice_, std::chrono::microseconds(100), std::chrono::seconds(4));
      if (dice_.Chance(0.35)) {
        DrawAimed();
      } else {
        AddAny();
      }
    }
    return std::move(incidents_);
  }

 private:
  Incident& Add(IncidentKind kind, const State& state, Duration after = {}) {
    at_ += after;
    Incident incident;
    incident.kind = kind;
    incident.at = at_;
    incident.actuator = dice_.Next() % config_.actuators.size();
    incident.state = state;
    incident.lasts = DrawLogUniform(dice_, Milliseconds(1), std::chrono::seconds(10));
    incident.chance = dice_.Next();
    if (kind == IncidentKind::kBattery) incident.state = AtBattery(incident);
    if (kind == IncidentKind::kBattery && !config_.policy) incident.kind = IncidentKind::kSet;
    incidents_.push_back(incident);
    return incidents_.back();
  }

  // What a battery at any level would have an application ask for, where there is no policy.
  State AtBattery(const Incident& incident) const {
    const auto percent = static_cast<int>(incident.chance % (kFull + 1));
    const State state{percent <= 5 ? kLowPower : (percent <= 20 ? kProtected : kActive)};
    return config_.HasState(state) ? state : config_.states.front();
  }

  // Another incident at the same time. Batteries fall and rise in a row.
  void MakeOfPolicy(Incident& incident) {
    incident.kind = kOfPolicy[policy_dice_.Next() % std::size(kOfPolicy)];
    incident.chance = policy_dice_.Next();
    if (incident.kind != IncidentKind::kBattery) return;
    const auto percent = static_cast<std::uint64_t>(DrawPercent(config_, incident.chance));
    const std::uint64_t cable = policy_dice_.Chance(0.3) ? 1 : 0;
    incident.chance = percent * 2 + cable;
  }

  // A client waits for a switch when the controller is killed.
  void AddOrphan() {
    Incident crash = incidents_.back();
    if (host_dice_.Chance(0.3)) crash.lasts = std::chrono::seconds(8);  // longer than it waits
    AddOfClient();
    Incident request = incidents_.back();
    request.kind = IncidentKind::kClientSet;
    request.at -=
        std::min(request.at, DrawLogUniform(host_dice_, Milliseconds(5), Milliseconds(80)));
    incidents_.pop_back();
    incidents_.back() = request;
    incidents_.push_back(crash);
  }

  // At the same time as the last one.
  void AddOfClient() {
    Incident incident = incidents_.back();
    incident.when.reset();
    incident.kind = kOfClients[host_dice_.Next() % std::size(kOfClients)];
    incident.actuator = host_dice_.Next() % config_.actuators.size();
    incident.state = DrawState(config_, host_dice_);
    incident.host = host_dice_.Next() % hosts_;
    incident.chance = host_dice_.Next();
    incidents_.push_back(incident);
  }

  // Another one at the same time.
  void MakeOfHosts(Incident& incident) {
    incident.kind =
        hosts_ > 1 ? kOfHosts[host_dice_.Next() % std::size(kOfHosts)] : IncidentKind::kReboot;
    incident.host = host_dice_.Next() % hosts_;
    incident.other_host = (incident.host + 1 + host_dice_.Next() % 2) % hosts_;
    if (incident.other_host == incident.host) incident.other_host = (incident.host + 1) % hosts_;
  }

  Incident& AddAny() {
    Incident& incident = Add(DrawKind(dice_), DrawState(config_, dice_));
    if (config_.policy && policy_dice_.Chance(kPolicyShare)) MakeOfPolicy(incident);
    if (incident.kind == IncidentKind::kCrash && exit_dice_.Chance(kWrongConfigShare)) {
      incident.kind = IncidentKind::kWrongConfig;
    }
    if (incident.kind == IncidentKind::kFullDisk && host_dice_.Chance(0.5)) {
      incident.kind = IncidentKind::kStalledDisk;
    }
    if (incident.kind == IncidentKind::kEmergencyStop && host_dice_.Chance(0.4)) {
      incident.kind = IncidentKind::kCrossingStops;
    }
    if (host_dice_.Chance(hosts_ > 1 ? kSeveralHostsShare : kHostShare)) MakeOfHosts(incident);
    return incident;
  }

  void DrawAimed() {
    static constexpr Moment kAims[] = {
        Moment::kJoining,     Moment::kSent,        Moment::kHalfWay,     Moment::kAsking,
        Moment::kRollingBack, Moment::kFallingBack, Moment::kTearingDown, Moment::kSettingUp};
    const Moment aim = kAims[dice_.Next() % std::size(kAims)];
    if (aim == Moment::kTearingDown && dice_.Chance(0.6)) return;  // little comes after it
    LeadTo(aim);
    AddAny().when = aim;
  }

  void LeadTo(Moment aim) {
    switch (aim) {
      case Moment::kAsking:
        Add(IncidentKind::kHang, {}).lasts = Milliseconds(100);
        Add(IncidentKind::kSet, DrawState(config_, dice_), Milliseconds(1));
        return;
      case Moment::kRollingBack:
        Add(IncidentKind::kSet, Least());
        Add(IncidentKind::kFail, {}, Milliseconds(300)).lasts = Milliseconds(100);
        Add(IncidentKind::kSet, State(kActive), Milliseconds(1));
        return;
      case Moment::kFallingBack:
        return LeadToFall();
      case Moment::kTearingDown:
        Add(IncidentKind::kSet, State(kTearDown));
        return;
      case Moment::kJoining:
        Add(IncidentKind::kCrash, {});
        return;
      default:
        Add(IncidentKind::kSet, DrawState(config_, dice_));
        return;
    }
  }

  // One with an on_lost dies until it is given up.
  void LeadToFall() {
    for (std::size_t i = 0; i < config_.actuators.size(); ++i) {
      const ActuatorConfig& actuator = config_.actuators[i];
      if (actuator.on_lost.empty() || actuator.restart.limit > 5) continue;
      const bool once = actuator.restart.policy == RestartPolicy::kNo || actuator.command.empty();
      const int lives = once ? 0 : actuator.restart.limit;
      double delay = static_cast<double>(actuator.restart.delay.count());
      Duration after{};
      for (int life = 0; life <= lives; ++life) {
        Add(IncidentKind::kCrash, {}, after).actuator = i;
        after = std::min(Duration(static_cast<Duration::rep>(delay)), actuator.restart.max_delay) +
                Milliseconds(300);
        delay *= actuator.restart.growth;
      }
      return;
    }
  }

  // The least active state that robots work in.
  State Least() const {
    for (const std::string_view state : {kLowPower, kDeActive, kProtected}) {
      if (config_.HasState(state)) return State(state);
    }
    return config_.states.front();
  }

  const MachineConfig& config_;
  Random dice_;
  Random policy_dice_;  // so that the rest of a life does not depend on it
  Random exit_dice_;    // nor on this
  Random host_dice_;
  std::size_t hosts_;
  Duration at_{};
  Incidents incidents_;
};

}  // namespace

std::string_view KindName(IncidentKind kind) {
  return RowOf(kind).name;
}

bool IsFault(IncidentKind kind) {
  const bool of_hosts = kind >= IncidentKind::kReboot && kind <= IncidentKind::kStalledDisk;
  return kind < IncidentKind::kSet || of_hosts;
}

Incidents DrawIncidents(const MachineConfig& config, std::uint64_t seed) {
  return Drawing(config, seed).Draw();
}

int BatteryOf(const Incident& incident) {
  return static_cast<int>(incident.chance / 2 % (kFull + 1));
}

bool ChargesIn(const Incident& incident) {
  return incident.chance % 2 == 1;
}

}  // namespace musher::simulation
