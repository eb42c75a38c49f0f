#include "musher/simulation/injection.hpp"

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
  InjectionKind kind;
  std::string_view name;
  int weight;             // of its probability
  std::string_view form;  // of its text
};

constexpr std::array<KindRow, kInjectionKinds> kKinds = {{
    {InjectionKind::kCrash, "crash", 9, "the process of {actuator} is killed"},
    // Some crashes become one, see below.
    {InjectionKind::kWrongConfig, "wrong-config", 0,
     "the configuration of {actuator} is wrong{lasts}: its process ends with exit code 2"},
    {InjectionKind::kFreeze, "freeze", 4, "the process of {actuator} is frozen (SIGSTOP){lasts}"},
    {InjectionKind::kHang, "hang", 4, "new callbacks of {actuator} hang{lasts}"},
    {InjectionKind::kSlow, "slow", 4, "callbacks of {actuator} are slow{lasts}"},
    {InjectionKind::kFail, "fail", 5, "callbacks of {actuator} fail{lasts}"},
    {InjectionKind::kLie, "lie", 2, "{actuator} publishes the false state {state}"},
    {InjectionKind::kLoss, "loss", 3, "messages are lost{lasts}"},
    {InjectionKind::kDelay, "delay", 3, "messages are delayed{lasts}"},
    {InjectionKind::kDuplication, "duplication", 3, "messages are duplicated{lasts}"},
    {InjectionKind::kReordering, "reordering", 3, "messages are reordered{lasts}"},
    {InjectionKind::kPartition, "partition", 3,
     "the link between {actuator} and the controller is cut{lasts}"},
    {InjectionKind::kDeaf, "deaf", 2, "the link from the controller to {actuator} is cut{lasts}"},
    {InjectionKind::kMute, "mute", 2, "the link from {actuator} to the controller is cut{lasts}"},
    {InjectionKind::kControllerCrash, "controller-crash", 4,
     "the controller is killed, and restarted after {ms}"},
    {InjectionKind::kControllerFreeze, "controller-freeze", 2,
     "the controller is frozen (SIGSTOP){lasts}"},
    {InjectionKind::kRival, "rival", 1, "a second controller is started"},
    {InjectionKind::kTakeover, "takeover", 1, "a second controller is started with --takeover"},
    {InjectionKind::kFullDisk, "full-disk", 2, "the controller's disk is full{lasts}"},
    {InjectionKind::kWallClock, "wall-clock", 1, "the wall clock jumps"},
    {InjectionKind::kSet, "set", 34, "the operator requests {state}"},
    {InjectionKind::kSetOne, "set-one", 4, "the operator requests {state} of {actuator}"},
    {InjectionKind::kBattery, "battery", 4, "the battery is at {battery} %{charging}"},
    {InjectionKind::kEmergencyStop, "emergency-stop", 3, "an emergency stop is engaged"},
    {InjectionKind::kRelease, "release", 4, "the emergency stop is released"},
    {InjectionKind::kRestart, "restart", 2, "the operator restarts {actuator}"},
    // These have random generators of their own.
    {InjectionKind::kStillness, "stillness", 0, "the body {moves}"},
    {InjectionKind::kWakeUp, "wake-up", 0, "the robot is woken up"},
    {InjectionKind::kKeep, "keep", 0, "an application keeps {state} for {seconds} s"},
    {InjectionKind::kOta, "ota", 0, "an application {enters} OTA"},
    {InjectionKind::kLowPowerSwitch, "low-power-switch", 0,
     "automatic LowPower when lying still is switched {on}"},
    {InjectionKind::kPowerOff, "power-off", 0, "the robot is switched off by its button"},
    // Some of the battery become one.
    {InjectionKind::kBatteryGlitch, "battery-glitch", 0,
     "one sample of the battery reports {battery} %"},
    {InjectionKind::kBatteryWriter, "battery-writer", 0,
     "a second program publishes a battery at {battery} %{lasts}"},
    {InjectionKind::kBatteryWalk, "battery-walk", 0,
     "the battery jitters around {battery} %{lasts}"},
    {InjectionKind::kReboot, "reboot", 0, "host {host} is rebooted and is back after {ms}"},
    {InjectionKind::kHostPartition, "host-partition", 0,
     "the link between hosts {host} and {other} is cut{lasts}"},
    {InjectionKind::kHostOneWay, "host-one-way", 0,
     "the link from host {host} to host {other} is cut{lasts}"},
    {InjectionKind::kStalledDisk, "stalled-disk", 0, "the controller's disk stalls{lasts}"},
    {InjectionKind::kCrossingStops, "crossing-stops", 0,
     "two panels engage an emergency stop, and a release crosses them"},
    {InjectionKind::kTakeBack, "take-back", 0,
     "the first controller is started again with --takeover"},
    {InjectionKind::kClientSet, "client-set", 0,
     "a client on host {host} requests {state}{of_one}"},
    {InjectionKind::kClientStatus, "client-status", 0,
     "a client on host {host} queries the status"},
    {InjectionKind::kClientRelease, "client-release", 0,
     "a client on host {host} releases the emergency stops"},
    {InjectionKind::kClientRestart, "client-restart", 0,
     "a client on host {host} restarts {actuator}"},
    {InjectionKind::kOtherMachine, "other-machine", 0,
     "another machine of the same namespace is in range{lasts}"},
    {InjectionKind::kOuterNetwork, "outer-network", 0, "host {host} has no outer network{lasts}"},
    {InjectionKind::kLostFiles, "lost-files", 0, "the files of the controller are removed"},
    {InjectionKind::kBridge, "bridge", 0, "a bridge repeats old statuses and heartbeats{lasts}"},
    {InjectionKind::kStopProgram, "stop-program", 0,
     "a program on host {host} engages an emergency stop{released}"},
    {InjectionKind::kManyStops, "many-stops", 0,
     "a panel engages emergency stops by the hundred{released}"},
    {InjectionKind::kUnnamedStop, "unnamed-stop", 0,
     "a panel engages an emergency stop without an id{released}"},
    {InjectionKind::kSilentBattery, "silent-battery", 0, "nothing publishes the battery{lasts}"},
    {InjectionKind::kSlowDiscovery, "slow-discovery", 0,
     "a client on host {host} needs up to 10 s to discover what it calls{lasts}"},
    {InjectionKind::kPermitFault, "permit-fault", 0, "{permit_fault}{lasts}"},
    {InjectionKind::kClockFault, "clock-fault", 0, "{clock_fault}"},
    {InjectionKind::kUnreadFolder, "unread-folder", 0,
     "another state folder of the machine may not be read from now on"},
    {InjectionKind::kClosedFolder, "closed-folder", 0,
     "the state folder of the controller cannot be opened at a start{lasts}"},
    {InjectionKind::kOtherUser, "other-user", 0,
     "the controller is killed, and another user starts it after {ms}"},
    {InjectionKind::kFrozen, "frozen", 0, "the process of {actuator} is frozen until it is ended"},
}};

// The share of process ends that are configuration errors.
constexpr double kWrongConfigShare = 0.2;

// The share of events that concern the policy, if there is one, and their kinds.
constexpr double kPolicyShare = 0.4;
constexpr InjectionKind kOfPolicy[] = {
    InjectionKind::kBattery,        InjectionKind::kBattery,   InjectionKind::kBattery,
    InjectionKind::kBattery,        InjectionKind::kStillness, InjectionKind::kStillness,
    InjectionKind::kWakeUp,         InjectionKind::kKeep,      InjectionKind::kOta,
    InjectionKind::kLowPowerSwitch, InjectionKind::kPowerOff};
constexpr int kFull = 100;
// The share of the battery's events that are faults of what publishes it, and their kinds.
constexpr double kSensorShare = 0.4;
constexpr InjectionKind kOfSensor[] = {InjectionKind::kBatteryGlitch, InjectionKind::kBatteryGlitch,
                                       InjectionKind::kBatteryWriter, InjectionKind::kBatteryWalk};

// The share of events that hit a host instead of a single process, with one host and with several.
constexpr double kHostShare = 0.03;
constexpr double kSeveralHostsShare = 0.15;
// The share of events with a client's request at the same time, and their kinds.
constexpr double kClientShare = 0.2;
constexpr double kOrphanShare = 0.6;
// The share of scenarios on three hosts in which a person takes over beyond a cut link.
constexpr double kPairShare = 0.4;
// The shares of scenarios with what is around the robot; the first two with several hosts.
constexpr double kOtherShare = 0.2;
constexpr double kOuterShare = 0.25;
constexpr double kLostFilesShare = 0.05;
constexpr double kBridgeShare = 0.3;
constexpr double kStopProgramShare = 0.15;
constexpr double kManyStopsShare = 0.03;
constexpr double kUnnamedStopShare = 0.05;
constexpr double kSilentBatteryShare = 0.25;  // of those with a battery in their policy
constexpr double kSlowDiscoveryShare = 0.15;
constexpr double kPermitShare = 0.4;  // of those with permit_ms in their config
constexpr double kClockShare = 0.5;   // of those with clock = "topic" and a policy
constexpr double kUnreadFolderShare = 0.04;
constexpr double kClosedFolderShare = 0.04;
constexpr double kOtherUserShare = 0.06;
constexpr double kFrozenShare = 0.08;
constexpr double kThenReleased = 0.7;
constexpr InjectionKind kOfClients[] = {
    InjectionKind::kClientSet,    InjectionKind::kClientSet,     InjectionKind::kClientStatus,
    InjectionKind::kClientStatus, InjectionKind::kClientRelease, InjectionKind::kClientRestart};
constexpr InjectionKind kOfHosts[] = {InjectionKind::kHostPartition, InjectionKind::kHostOneWay,
                                      InjectionKind::kHostOneWay, InjectionKind::kReboot};

// Mostly around the policy's levels, and at both ends.
int SamplePercent(const MachineConfig& config, std::uint64_t random) {
  const BatteryPolicy battery = config.policy->battery.value_or(BatteryPolicy{});
  const int near[] = {battery.tear_down_at, battery.low_power_at, battery.protected_at};
  const auto spread = static_cast<int>(random / 8 % 8) - 3;
  switch (random % 8) {
    case 0:
      return static_cast<int>(random / 8 % (kFull + 1));
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

const KindRow& RowOf(InjectionKind kind) {
  return kKinds[static_cast<std::size_t>(kind)];
}

InjectionKind SampleKind(Random& random) {
  int left = static_cast<int>(random.Next() % kAllWeights);
  for (const KindRow& row : kKinds) {
    left -= row.weight;
    if (left < 0) return row.kind;
  }
  return InjectionKind::kSet;
}

// Log-uniform: as likely between 1 and 10 ms as between 1 and 10 s.
Duration SampleLogUniform(Random& random, Duration least, Duration most) {
  constexpr double kUnit = 1.0 / 9007199254740992.0;  // 2^-53
  const double share = static_cast<double>(random.Next() >> 11) * kUnit;
  const double ratio = static_cast<double>(most.count()) / static_cast<double>(least.count());
  return Duration(
      static_cast<Duration::rep>(static_cast<double>(least.count()) * std::pow(ratio, share)));
}

// A state that can be requested; TearDown, after which little happens, is rare.
State SampleState(const MachineConfig& config, Random& random) {
  std::vector<State> states;
  for (const State& state : config.states) {
    if (state == kSetUp || state == kTearDown) continue;
    states.push_back(state);
  }
  if (states.empty() || (config.HasState(kTearDown) && random.Bernoulli(0.02)))
    return State(kTearDown);
  return states[random.Next() % states.size()];
}

// Samples the events of a scenario, some aimed at phases that few would hit at random.
class InjectionSampler {
 public:
  InjectionSampler(const MachineConfig& config, std::uint64_t seed)
      : config_(config),
        random_(seed * 2 + 1),
        policy_random_(seed * 2 + 0x706f6c),
        exit_random_(seed * 2 + 0x65786974),
        sensor_random_(seed * 2 + 0x73656e73),
        host_random_(seed * 2 + 0x72656274),
        pair_random_(seed * 2 + 0x70616972),
        around_random_(seed * 2 + 0x61726f75),
        late_random_(seed * 2 + 0x6c617465),
        permit_random_(seed * 2 + 0x7065726d),
        clock_random_(seed * 2 + 0x636c6f63),
        folder_random_(seed * 2 + 0x666f6c64),
        user_random_(seed * 2 + 0x75736572),
        frozen_random_(seed * 2 + 0x66726f7a),
        hosts_(SampleLayout(config, seed, false).hosts.size()) {}

  Injections Sample(bool bridges) {
    const std::uint64_t drawn = random_.Next();
    const std::uint64_t count = 1 + drawn % (1 + random_.Next() % 16);
    for (std::uint64_t i = 0; i < count; ++i) {
      const bool crash =
          !injections_.empty() && injections_.back().kind == InjectionKind::kControllerCrash;
      if (crash && host_random_.Bernoulli(kOrphanShare)) AddOrphan();
      if (!injections_.empty() && host_random_.Bernoulli(kClientShare)) AddOfClient();
      at_ += SampleLogUniform(random_, std::chrono::microseconds(100), std::chrono::seconds(4));
      if (random_.Bernoulli(0.35)) {
        AddAimed();
      } else {
        AddAny();
      }
    }
    if (hosts_ > 2 && pair_random_.Bernoulli(kPairShare)) AddPair();
    AddAround();
    if (bridges && Random(around_random_).Bernoulli(kBridgeShare)) {
      Insert(around_random_, InjectionKind::kBridge, std::chrono::seconds(1),
             std::chrono::seconds(20));
    }
    AddLate();
    AddOfPermits();
    AddOfClock();
    AddOfFolders();
    AddOfUsers();
    if (frozen_random_.Bernoulli(kFrozenShare)) {
      Insert(frozen_random_, InjectionKind::kFrozen, {}, {});
    }
    return std::move(injections_);
  }

 private:
  // The link between the hosts of the two controllers is cut, both reach a third host, and an
  // operator takes over on the second one. What follows meets both controllers.
  void AddPair() {
    const auto add = [this](InjectionKind kind, Duration least, Duration most) -> Injection& {
      at_ += SampleLogUniform(pair_random_, least, most);
      Injection injection;
      injection.kind = kind;
      injection.at = at_;
      injection.actuator = ActuatorIndex(pair_random_.Next() % config_.actuators.size());
      injection.host = 0;
      injection.other_host = 1;
      injection.state = SampleState(config_, pair_random_);
      injection.lasts =
          SampleLogUniform(pair_random_, std::chrono::seconds(2), std::chrono::seconds(40));
      injection.random = pair_random_.Next();
      return injections_.emplace_back(std::move(injection));
    };
    add(InjectionKind::kHostPartition, Milliseconds(10), std::chrono::seconds(8));
    add(InjectionKind::kTakeover, Milliseconds(1), std::chrono::seconds(3));
    for (std::uint64_t left = pair_random_.Next() % 5; left > 0; --left) {
      static constexpr InjectionKind kKindsThen[] = {
          InjectionKind::kClientSet, InjectionKind::kClientSet, InjectionKind::kSet,
          InjectionKind::kTakeBack,  InjectionKind::kCrash,     InjectionKind::kReboot,
          InjectionKind::kTakeover};
      const InjectionKind kind = kKindsThen[pair_random_.Next() % std::size(kKindsThen)];
      Injection& injection = add(kind, Milliseconds(10), std::chrono::seconds(6));
      injection.host = pair_random_.Next() % hosts_;
    }
  }

  void AddAround() {
    using std::chrono::seconds;
    const auto maybe = [this](InjectionKind kind, double share, Duration least, Duration most) {
      if (around_random_.Bernoulli(share)) Insert(around_random_, kind, least, most);
    };
    const bool lan = config_.transport == TransportProfile::kLan;
    maybe(InjectionKind::kOtherMachine, lan ? kOtherShare : 0, seconds(3), seconds(40));
    maybe(InjectionKind::kOuterNetwork, hosts_ > 1 ? kOuterShare : 0, Milliseconds(200),
          seconds(20));
    maybe(InjectionKind::kLostFiles, kLostFilesShare, {}, {});
    const Duration released = Milliseconds(1);
    maybe(InjectionKind::kStopProgram, kStopProgramShare, released, seconds(12));
    maybe(InjectionKind::kManyStops, kManyStopsShare, released, seconds(12));
    maybe(InjectionKind::kUnnamedStop, kUnnamedStopShare, released, seconds(12));
  }

  // What is late: the battery's samples, over a restart of the controller as well; and what a
  // client discovers.
  void AddLate() {
    using std::chrono::seconds;
    const bool battery = config_.policy && config_.policy->battery;
    if (battery && late_random_.Bernoulli(kSilentBatteryShare)) {
      const Injection silent =
          Insert(late_random_, InjectionKind::kSilentBattery, Milliseconds(500), seconds(20));
      if (late_random_.Bernoulli(0.7)) {
        InsertWithin(late_random_, silent, InjectionKind::kControllerCrash);
      }
    }
    if (!late_random_.Bernoulli(kSlowDiscoveryShare)) return;
    const Injection slow =
        Insert(late_random_, InjectionKind::kSlowDiscovery, seconds(2), seconds(20));
    for (std::uint64_t requests = 1 + late_random_.Next() % 3; requests > 0; --requests) {
      InsertWithin(late_random_, slow, kOfClients[late_random_.Next() % std::size(kOfClients)]);
    }
  }

  // Faults of the permits to move. In most scenarios a person then releases the stop, and switches
  // the machine up again; in some the controller is killed meanwhile.
  void AddOfPermits() {
    using std::chrono::seconds;
    if (!config_.permit || !permit_random_.Bernoulli(kPermitShare)) return;
    for (std::uint64_t faults = 1 + permit_random_.Next() % 3; faults > 0; --faults) {
      const Injection fault =
          Insert(permit_random_, InjectionKind::kPermitFault, Milliseconds(20), seconds(12));
      if (permit_random_.Bernoulli(0.3)) {
        InsertWithin(permit_random_, fault, InjectionKind::kControllerCrash);
      }
      if (permit_random_.Bernoulli(0.3)) InsertWithin(permit_random_, fault, InjectionKind::kCrash);
      if (!permit_random_.Bernoulli(kThenReleased)) continue;
      Injection then = fault;
      then.kind = InjectionKind::kRelease;
      then.at += permit_random_.Between({}, fault.lasts * 2);
      Insert(then);
      if (permit_random_.Bernoulli(0.5)) continue;
      then.kind = InjectionKind::kSet;
      then.state = State(kActive);
      then.at += permit_random_.Between(Milliseconds(1), seconds(4));
      if (config_.HasState(kActive)) Insert(then);
    }
  }

  // Faults of /clock, and what is timed by it meanwhile.
  void AddOfClock() {
    using std::chrono::seconds;
    const bool by_topic = config_.policy && config_.clock == ClockSource::kTopic;
    if (!by_topic || !clock_random_.Bernoulli(kClockShare)) return;
    for (std::uint64_t faults = 1 + clock_random_.Next() % 4; faults > 0; --faults) {
      const Injection fault =
          Insert(clock_random_, InjectionKind::kClockFault, Milliseconds(200), seconds(20));
      static constexpr InjectionKind kTimed[] = {
          InjectionKind::kStillness, InjectionKind::kStillness,
          InjectionKind::kKeep,      InjectionKind::kWakeUp,
          InjectionKind::kSet,       InjectionKind::kLowPowerSwitch,
          InjectionKind::kOta,       InjectionKind::kControllerCrash};
      for (std::uint64_t timed = clock_random_.Next() % 4; timed > 0; --timed) {
        InsertWithin(clock_random_, fault, kTimed[clock_random_.Next() % std::size(kTimed)]);
      }
    }
  }

  // What the next start finds. In most scenarios all processes of a host end meanwhile, so that a
  // start from the first state follows.
  void AddOfFolders() {
    if (!folder_random_.Bernoulli(kUnreadFolderShare)) return;
    const Injection folder = Insert(folder_random_, InjectionKind::kUnreadFolder, Milliseconds(1),
                                    std::chrono::seconds(4));
    InsertWithin(
        folder_random_, folder,
        folder_random_.Bernoulli(0.7) ? InjectionKind::kReboot : InjectionKind::kControllerCrash);
  }

  // Its own folder cannot be opened; or another user starts the machine, in most scenarios after a
  // stop, or while nothing publishes the battery.
  void AddOfUsers() {
    using std::chrono::seconds;
    if (user_random_.Bernoulli(kClosedFolderShare)) {
      const Injection folder =
          Insert(user_random_, InjectionKind::kClosedFolder, Milliseconds(500), seconds(12));
      const bool boots = user_random_.Bernoulli(0.7);
      InsertWithin(user_random_, folder,
                   boots ? InjectionKind::kReboot : InjectionKind::kControllerCrash);
    }
    if (!user_random_.Bernoulli(kOtherUserShare)) return;
    Injection change = Insert(user_random_, InjectionKind::kOtherUser, Milliseconds(1), seconds(6));
    const auto before = [&](InjectionKind kind, Duration lasts) {
      Injection cause = change;
      cause.kind = kind;
      cause.at -= std::min(cause.at, user_random_.Between(Milliseconds(1), seconds(4)));
      cause.lasts = lasts;
      cause.random = user_random_.Next();
      Insert(cause);
    };
    if (user_random_.Bernoulli(0.6)) before(InjectionKind::kStopProgram, {});
    const bool battery = config_.policy && config_.policy->battery;
    if (battery && user_random_.Bernoulli(0.5)) {
      before(InjectionKind::kSilentBattery, seconds(20));
    }
    if (user_random_.Bernoulli(0.5)) return;
    change.at += user_random_.Between(Milliseconds(1), seconds(12));
    change.random = user_random_.Next();
    Insert(change);  // the first one again
  }

  // While another one lasts, on the same host.
  void InsertWithin(Random& random, const Injection& other, InjectionKind kind) {
    Injection injection = other;
    injection.kind = kind;
    injection.at += random.Between({}, other.lasts);
    injection.state = SampleState(config_, random);
    injection.lasts = SampleLogUniform(random, Milliseconds(1), std::chrono::seconds(10));
    injection.random = random.Next();
    Insert(injection);
  }

  // Somewhere among the others. A stop lasts until it is released; zero: it is not.
  Injection Insert(Random& random, InjectionKind kind, Duration least, Duration most) {
    Injection injection;
    injection.kind = kind;
    injection.at = random.Between({}, at_ + std::chrono::seconds(2));
    injection.actuator = ActuatorIndex(random.Next() % config_.actuators.size());
    injection.host = random.Next() % hosts_;
    injection.lasts = most <= least ? least : SampleLogUniform(random, least, most);
    const bool stop = kind >= InjectionKind::kStopProgram && kind <= InjectionKind::kUnnamedStop;
    if (stop && !random.Bernoulli(kThenReleased)) injection.lasts = {};
    injection.random = random.Next();
    Insert(injection);
    return injection;
  }

  void Insert(const Injection& injection) {
    const auto later = std::find_if(injections_.begin(), injections_.end(),
                                    [&](const auto& one) { return one.at > injection.at; });
    injections_.insert(later, injection);
  }

  Injection& Add(InjectionKind kind, const State& state, Duration after = {}) {
    at_ += after;
    Injection injection;
    injection.kind = kind;
    injection.at = at_;
    injection.actuator = ActuatorIndex(random_.Next() % config_.actuators.size());
    injection.state = state;
    injection.lasts = SampleLogUniform(random_, Milliseconds(1), std::chrono::seconds(10));
    injection.random = random_.Next();
    if (kind == InjectionKind::kBattery) injection.state = AtBattery(injection);
    if (kind == InjectionKind::kBattery && !config_.policy) injection.kind = InjectionKind::kSet;
    // Much comes after a TearDown of one actuator.
    const bool ends_one = kind == InjectionKind::kSetOne && injection.random % 8 == 0;
    if (ends_one && config_.HasState(kTearDown)) injection.state = State(kTearDown);
    injections_.push_back(injection);
    return injections_.back();
  }

  // The state that an application would request for the battery's level, where there is no policy.
  State AtBattery(const Injection& injection) const {
    const auto percent = static_cast<int>(injection.random % (kFull + 1));
    const State state{percent <= 5 ? kLowPower : (percent <= 20 ? kProtected : kActive)};
    return config_.HasState(state) ? state : config_.states.front();
  }

  // Replaces the event by one that concerns the policy.
  void MakeOfPolicy(Injection& injection) {
    injection.kind = kOfPolicy[policy_random_.Next() % std::size(kOfPolicy)];
    injection.random = policy_random_.Next();
    if (injection.kind != InjectionKind::kBattery) return;
    const auto percent = static_cast<std::uint64_t>(SamplePercent(config_, injection.random));
    const std::uint64_t cable = policy_random_.Bernoulli(0.3) ? 1 : 0;
    injection.random = percent * 2 + cable;
    if (!sensor_random_.Bernoulli(kSensorShare)) return;
    injection.kind = kOfSensor[sensor_random_.Next() % std::size(kOfSensor)];
  }

  // Adds a client's switch that is under way when the controller is killed.
  void AddOrphan() {
    Injection crash = injections_.back();
    if (host_random_.Bernoulli(0.3))
      crash.lasts = std::chrono::seconds(8);  // longer than the client waits
    AddOfClient();
    Injection request = injections_.back();
    request.kind = InjectionKind::kClientSet;
    request.at -=
        std::min(request.at, SampleLogUniform(host_random_, Milliseconds(5), Milliseconds(80)));
    injections_.pop_back();
    injections_.back() = request;
    injections_.push_back(crash);
  }

  // Adds a client's request at the time of the last event.
  void AddOfClient() {
    Injection injection = injections_.back();
    injection.when.reset();
    injection.kind = kOfClients[host_random_.Next() % std::size(kOfClients)];
    injection.actuator = ActuatorIndex(host_random_.Next() % config_.actuators.size());
    injection.state = SampleState(config_, host_random_);
    injection.host = host_random_.Next() % hosts_;
    injection.random = host_random_.Next();
    injections_.push_back(injection);
  }

  // Replaces the event by one that hits a host.
  void MakeOfHosts(Injection& injection) {
    injection.kind =
        hosts_ > 1 ? kOfHosts[host_random_.Next() % std::size(kOfHosts)] : InjectionKind::kReboot;
    injection.host = host_random_.Next() % hosts_;
    injection.other_host = (injection.host + 1 + host_random_.Next() % 2) % hosts_;
    if (injection.other_host == injection.host)
      injection.other_host = (injection.host + 1) % hosts_;
  }

  Injection& AddAny() {
    const State state = SampleState(config_, random_);
    Injection& injection = Add(SampleKind(random_), state);
    if (config_.policy && policy_random_.Bernoulli(kPolicyShare)) MakeOfPolicy(injection);
    if (injection.kind == InjectionKind::kCrash && exit_random_.Bernoulli(kWrongConfigShare)) {
      injection.kind = InjectionKind::kWrongConfig;
    }
    if (injection.kind == InjectionKind::kFullDisk && host_random_.Bernoulli(0.5)) {
      injection.kind = InjectionKind::kStalledDisk;
    }
    if (injection.kind == InjectionKind::kEmergencyStop && host_random_.Bernoulli(0.4)) {
      injection.kind = InjectionKind::kCrossingStops;
    }
    if (host_random_.Bernoulli(hosts_ > 1 ? kSeveralHostsShare : kHostShare))
      MakeOfHosts(injection);
    return injection;
  }

  void AddAimed() {
    static constexpr MachinePhase kAims[] = {MachinePhase::kJoining,     MachinePhase::kSent,
                                             MachinePhase::kPartlyDone,  MachinePhase::kOverdue,
                                             MachinePhase::kRollingBack, MachinePhase::kFallingBack,
                                             MachinePhase::kTearingDown, MachinePhase::kSettingUp};
    const MachinePhase aim = kAims[random_.Next() % std::size(kAims)];
    if (aim == MachinePhase::kTearingDown && random_.Bernoulli(0.6))
      return;  // little comes after it
    LeadTo(aim);
    AddAny().when = aim;
  }

  void LeadTo(MachinePhase aim) {
    switch (aim) {
      case MachinePhase::kOverdue:
        Add(InjectionKind::kHang, {}).lasts = Milliseconds(100);
        Add(InjectionKind::kSet, SampleState(config_, random_), Milliseconds(1));
        return;
      case MachinePhase::kRollingBack:
        Add(InjectionKind::kSet, Least());
        Add(InjectionKind::kFail, {}, Milliseconds(300)).lasts = Milliseconds(100);
        Add(InjectionKind::kSet, State(kActive), Milliseconds(1));
        return;
      case MachinePhase::kFallingBack:
        return LeadToFallback();
      case MachinePhase::kTearingDown:
        Add(InjectionKind::kSet, State(kTearDown));
        return;
      case MachinePhase::kJoining:
        Add(InjectionKind::kCrash, {});
        return;
      default:
        Add(InjectionKind::kSet, SampleState(config_, random_));
        return;
    }
  }

  // Crashes an actuator that has an on_lost until it is given up.
  void LeadToFallback() {
    for (const ActuatorIndex i : config_.actuators.Indices()) {
      const ActuatorConfig& actuator = config_.actuators[i];
      if (actuator.on_lost.empty() || actuator.restart.limit > 5) continue;
      const bool once = actuator.restart.policy == RestartPolicy::kNo || actuator.command.empty();
      const int restarts = once ? 0 : actuator.restart.limit;
      double delay = static_cast<double>(actuator.restart.delay.count());
      Duration after{};
      for (int crash = 0; crash <= restarts; ++crash) {
        Add(InjectionKind::kCrash, {}, after).actuator = i;
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
  Random random_;
  // Generators of their own, so that the other events do not depend on them.
  Random policy_random_;
  Random exit_random_;
  Random sensor_random_;
  Random host_random_;
  Random pair_random_;
  Random around_random_;
  Random late_random_;
  Random permit_random_;
  Random clock_random_;
  Random folder_random_;
  Random user_random_;
  Random frozen_random_;
  std::size_t hosts_;
  Duration at_{};
  Injections injections_;
};

}  // namespace

std::string_view FormOf(InjectionKind kind) {
  return RowOf(kind).form;
}

std::string_view KindName(InjectionKind kind) {
  return RowOf(kind).name;
}

bool IsFault(InjectionKind kind) {
  const bool of_hosts = kind >= InjectionKind::kReboot && kind <= InjectionKind::kStalledDisk;
  const bool of_sensor =
      kind >= InjectionKind::kBatteryGlitch && kind <= InjectionKind::kBatteryWalk;
  const bool around = kind >= InjectionKind::kOtherMachine && kind <= InjectionKind::kBridge;
  const bool late = kind >= InjectionKind::kSilentBattery;
  return kind < InjectionKind::kSet || of_hosts || of_sensor || around || late;
}

bool IsAround(InjectionKind kind) {
  return kind >= InjectionKind::kOtherMachine;
}

Injections SampleInjections(const MachineConfig& config, std::uint64_t seed, bool bridges) {
  return InjectionSampler(config, seed).Sample(bridges);
}

PermitFault PermitFaultOf(const Injection& injection) {
  return static_cast<PermitFault>(injection.random % 4);
}

ClockFault ClockFaultOf(const Injection& injection) {
  return static_cast<ClockFault>(injection.random % 5);
}

std::int64_t ClockRateOf(const Injection& injection) {
  constexpr std::array<std::int64_t, 5> kRates = {100, 300, 2000, 5000, 10'000};
  return kRates[injection.random / 8 % kRates.size()];
}

// A longer step forward than a clock makes, or back.
Duration ClockJumpOf(const Injection& injection) {
  const Duration by(std::chrono::seconds(11 + injection.random / 8 % 100));
  return ClockFaultOf(injection) == ClockFault::kBack ? -by : by;
}

int BatteryOf(const Injection& injection) {
  return static_cast<int>(injection.random / 2 % (kFull + 1));
}

bool ChargesIn(const Injection& injection) {
  return injection.random % 2 == 1;
}

}  // namespace musher::simulation
