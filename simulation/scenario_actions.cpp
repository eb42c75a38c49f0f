// How injected events act on the robot.

#include <algorithm>

#include "musher/simulation/scenario.hpp"

namespace musher::simulation {

using transport::sim::LinkFaults;

namespace {

constexpr std::int32_t kLying = 0;
constexpr std::int32_t kWalking = 303;
constexpr int kMostBattery = 100;
constexpr Duration kWalkPeriod = Milliseconds(300);  // of the samples of a battery that jitters

}  // namespace

// A crash ends all actuators of the process.
void Scenario::NoteCrash(ActuatorIndex process) {
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    if (robot_.layout().ProcessOf(i) == process) checker_.OnCrash(config_.actuators[i].name);
  }
}

void Scenario::Apply(const Injection& injection) {
  const std::string& name = config_.actuators[injection.actuator].name;
  const Time now = robot_.network().now();
  FaultWindow& window = fault_windows_[injection.actuator];
  switch (injection.kind) {
    case InjectionKind::kCrash:
      if (robot_.IsAlive(name)) NoteCrash(robot_.layout().ProcessOf(injection.actuator));
      return robot_.CrashActuator(name);
    case InjectionKind::kWrongConfig:
      return Misconfigure(name, injection.lasts);
    case InjectionKind::kFreeze:
      if (!robot_.IsAlive(name)) return;
      robot_.FreezeActuator(name);
      return Later(injection.lasts, [this, name] {
        if (robot_.IsAlive(name)) robot_.ThawActuator(name);
      });
    case InjectionKind::kHang:
      window.hangs = now + injection.lasts;
      return;
    case InjectionKind::kSlow:
      window.slow = now + injection.lasts;
      return;
    case InjectionKind::kFail:
      window.fails = now + injection.lasts;
      return;
    case InjectionKind::kLie:
      if (!robot_.IsAlive(name)) return;
      checker_.OnFalseReport(name, injection.state);
      return robot_.Lie(name, injection.state);
    case InjectionKind::kSet:
      return RequestSwitch(injection.state);
    case InjectionKind::kSetOne:
      return RequestSwitch(injection.state, name);
    case InjectionKind::kBattery:
      return robot_.SetBattery(BatteryOf(injection), ChargesIn(injection));
    case InjectionKind::kEmergencyStop:
      return Engage(injection.random / 2 % 2, StopId(injection.random | 1));
    case InjectionKind::kRelease:
      return robot_.ReleaseEmergencyStop();
    case InjectionKind::kTakeBack:
      return robot_.TakeBack();
    case InjectionKind::kRestart:
      checker_.OnRestartRequest(name);
      return robot_.Restart(name);
    default:
      if (injection.kind >= InjectionKind::kClientSet) return ApplyByClient(injection);
      if (injection.kind == InjectionKind::kCrossingStops) return ApplyToStops(injection);
      if (injection.kind == InjectionKind::kStalledDisk) return ApplyToController(injection);
      if (injection.kind >= InjectionKind::kReboot) return ApplyToHosts(injection);
      if (injection.kind >= InjectionKind::kBatteryGlitch) return ApplyToBattery(injection);
      if (injection.kind > InjectionKind::kRestart) return ApplyToPolicy(injection);
      return injection.kind < InjectionKind::kControllerCrash ? ApplyToNetwork(injection)
                                                              : ApplyToController(injection);
  }
}

void Scenario::Misconfigure(const std::string& name, Duration lasts) {
  robot_.processes().Misconfigure(name, true);
  if (robot_.IsAlive(name)) {
    checker_.OnWrongConfig(name);
    robot_.processes().End(name, WrongConfigExit());
  }
  Later(lasts, [this, name] { robot_.processes().Misconfigure(name, false); });
}

void Scenario::ApplyToPolicy(const Injection& injection) {
  const std::uint64_t random = injection.random;
  switch (injection.kind) {
    case InjectionKind::kStillness:
      return robot_.SetMotion(random % 4 == 0 ? kWalking : kLying);
    case InjectionKind::kWakeUp:
      return RequestPolicy({0, PolicyRequest::kWakeUp, "", 0, false});
    case InjectionKind::kKeep:
      return RequestPolicy(
          {0, PolicyRequest::kKeep, injection.state, static_cast<std::int64_t>(random % 8), false});
    case InjectionKind::kOta:
      return RequestPolicy({0, PolicyRequest::kOta, "", 0, random % 2 == 0});
    case InjectionKind::kLowPowerSwitch:
      return RequestPolicy({0, PolicyRequest::kLowPowerSwitch, "", 0, random % 3 != 0});
    default:
      return RequestPolicy({0, PolicyRequest::kPowerOff, "", 0, false});
  }
}

// Faults of what publishes the battery.
void Scenario::ApplyToBattery(const Injection& injection) {
  switch (injection.kind) {
    case InjectionKind::kBatteryGlitch:
      return robot_.GlitchBattery(BatteryOf(injection), ChargesIn(injection));
    case InjectionKind::kBatteryWriter:
      robot_.SetOtherBattery(BatteryOf(injection));
      return Later(injection.lasts, [this] { robot_.SetOtherBattery(std::nullopt); });
    default:
      robot_.SetBattery(BatteryOf(injection), false);
      return WalkBattery(transport::sim::Random(injection.random),
                         robot_.network().now() + injection.lasts);
  }
}

void Scenario::WalkBattery(transport::sim::Random random, Time until) {
  if (robot_.network().now() >= until) return;
  const int step = static_cast<int>(random.Next() % 7) - 3;
  robot_.SetBattery(std::clamp(robot_.battery().value_or(kMostBattery) + step, 0, kMostBattery),
                    false);
  Later(kWalkPeriod, [this, random, until] { WalkBattery(random, until); });
}

void Scenario::RequestPolicy(const event::PolicyRequested& requested) {
  ControllerProcess* leader = robot_.leader();
  if (leader == nullptr || leader->frozen) return;
  const std::uint64_t request = checker_.OnPolicyRequest(*leader, requested);
  leader->shell().SendPolicyRequest(requested, [this, request, requested](const Result<>& reply) {
    Mix(reply ? "ok" : reply.error().message);
    checker_.OnPolicyReply(request, requested, reply);
  });
}

void Scenario::ApplyToNetwork(const Injection& injection) {
  if (injection.kind < InjectionKind::kPartition) {
    const auto which =
        static_cast<std::size_t>(injection.kind) - static_cast<std::size_t>(InjectionKind::kLoss);
    ++network_faults_[which];
    ApplyNetworkFaults();
    return Later(injection.lasts, [this, which] {
      --network_faults_[which];
      ApplyNetworkFaults();
    });
  }
  const bool deaf = injection.kind != InjectionKind::kMute;
  const bool mute = injection.kind != InjectionKind::kDeaf;
  const ActuatorIndex process = robot_.layout().ProcessOf(injection.actuator);
  const auto set = [this, name = config_.actuators[process].name, deaf, mute](bool blocked) {
    for (const char* controller : SimRobot::kControllerEndpoints) {
      if (deaf) robot_.hosts().SetBlocked(controller, name, blocked);
      if (mute) robot_.hosts().SetBlocked(name, controller, blocked);
    }
  };
  set(true);
  Later(injection.lasts, [set] { set(false); });
}

void Scenario::Engage(std::size_t panel, StopId id) {
  checker_.OnStopEngaged(panel, id);
  robot_.EngageEmergencyStop(id, panel);
}

// Two panels engage a stop; the release comes between them or at about the same time.
void Scenario::ApplyToStops(const Injection& injection) {
  const std::uint64_t random = injection.random;
  const std::size_t panel = random / 2 % 2;
  Engage(panel, StopId(random | 1));
  Later(Milliseconds(static_cast<std::int64_t>(random / 16 % 40)),
        [this, panel, id = StopId((random >> 9) | 1)] { Engage(1 - panel, id); });
  Later(Milliseconds(static_cast<std::int64_t>(random / 1024 % 60)),
        [this] { robot_.ReleaseEmergencyStop(); });
}

void Scenario::ApplyByClient(const Injection& injection) {
  Client& client = robot_.ClientOn(injection.host);
  client.on_end = [this](const Client::Request&, const SwitchEnd& end) {
    ++ending_.client_ends[static_cast<std::size_t>(end.kind)];
    Mix(end.result.outcome);
  };
  client.on_reply = [this](bool replied) { ++ending_.client_calls[replied ? 1 : 0]; };
  const std::string& name = config_.actuators[injection.actuator].name;
  switch (injection.kind) {
    case InjectionKind::kClientSet:
      checker_.OnClientRequest(injection.state);
      return client.SetState(injection.state, injection.random % 8 == 0 ? name : "");
    case InjectionKind::kClientRelease:
      return client.ReleaseEmergencyStop();
    case InjectionKind::kClientRestart:
      checker_.OnRestartRequest(name);
      return client.Restart(name);
    default:
      return client.GetStatus();
  }
}

void Scenario::ApplyToHosts(const Injection& injection) {
  const std::size_t from = injection.host;
  const std::size_t to = injection.other_host;
  if (injection.kind == InjectionKind::kReboot) return Reboot(from, injection.lasts);
  const auto set = [this, from, to,
                    both = injection.kind == InjectionKind::kHostPartition](bool blocked) {
    robot_.hosts().SetHostBlocked(from, to, blocked);
    if (both) robot_.hosts().SetHostBlocked(to, from, blocked);
  };
  set(true);
  Later(injection.lasts, [set] { set(false); });
}

// After the reboot the actuators that are started by hand, and a controller that ran on the host,
// start again.
void Scenario::Reboot(std::size_t host, Duration lasts) {
  bool had_controller = false;
  for (std::size_t which = 0; which < 2; ++which) {
    const ControllerProcess* controller = robot_.controller(which);
    had_controller |= controller != nullptr && controller->host() == host;
  }
  robot_.RebootHost(host);
  Later(lasts, [this, host, had_controller] {
    for (const ActuatorIndex i : config_.actuators.Indices()) {
      if (IsByHand(i) && robot_.layout().HostOf(i) == host) StartByHand(i);
    }
    const bool here = robot_.layout().controllers[0] == host;
    if (had_controller && robot_.MayStartFirst()) StartController(supervised_ && here);
  });
}

void Scenario::ApplyNetworkFaults() {
  LinkFaults faults;
  if (network_faults_[0] > 0) faults.loss = 0.2;
  if (network_faults_[1] > 0) faults.delay_max = Milliseconds(80);
  if (network_faults_[2] > 0) faults.duplication = 0.3;
  if (network_faults_[3] > 0) faults.reordering = 0.3;
  robot_.network().SetFaults(faults);
}

void Scenario::ApplyToController(const Injection& injection) {
  if (injection.kind != InjectionKind::kWallClock) {
    checker_.OnControllersBlocked(injection.kind == InjectionKind::kFullDisk ||
                                  injection.kind == InjectionKind::kStalledDisk);
  }
  switch (injection.kind) {
    case InjectionKind::kControllerCrash: {
      // A supervisor restarts only a controller that crashed on its own host.
      const bool restarted = supervised_ && (robot_.controller(0) != nullptr || robot_.OneHost());
      robot_.CrashController();
      return Later(injection.lasts, [this, restarted] {
        if (robot_.MayStartFirst()) StartController(restarted);
      });
    }
    case InjectionKind::kStalledDisk:
      robot_.StallDisk(true);
      return Later(injection.lasts, [this] { robot_.StallDisk(false); });
    case InjectionKind::kControllerFreeze:
      robot_.FreezeController();
      return Later(injection.lasts, [this] { robot_.ThawController(); });
    case InjectionKind::kRival:
      return robot_.StartRival(false);
    case InjectionKind::kTakeover:
      return robot_.StartRival(true);
    case InjectionKind::kFullDisk:
      robot_.FillDisk(true);
      return Later(injection.lasts, [this] { robot_.FillDisk(false); });
    default:
      return robot_.JumpWallClock(
          Milliseconds(static_cast<std::int64_t>(injection.random % 7'200'000)) -
          std::chrono::hours(1));
  }
}

void Scenario::RequestSwitch(const State& target, const std::optional<std::string>& actuator) {
  ControllerProcess* leader = robot_.leader();
  if (leader == nullptr || leader->frozen) return;
  const std::uint64_t request = checker_.OnRequest(*leader, target);
  leader->shell().SetState(target, actuator, [this, request](const SwitchResult& result) {
    ++ending_.switches[static_cast<std::size_t>(result.outcome)];
    Mix(std::string(OutcomeName(result.outcome)));
    checker_.OnReply(request, result);
  });
}

}  // namespace musher::simulation
