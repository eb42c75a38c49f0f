// How injected events act on the robot.

#include <algorithm>

#include "musher/simulation/scenario.hpp"

namespace musher::simulation {

using transport::sim::LinkFaults;

namespace {

constexpr std::int32_t kLying = 0;
constexpr std::int32_t kWalking = 303;
constexpr int kMostBattery = 100;
constexpr std::size_t kFirstProgram = 100;           // that engages stops, beside the panels
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
      if (IsAround(injection.kind)) return ApplyAround(injection);
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

// A panel has no identity: it stops every machine in reach.
void Scenario::Engage(std::size_t panel, StopId id, const std::string& by) {
  if (id != 0) checker_.OnStopEngaged(panel, id);
  if (id != 0 && other_) other_->checker().OnStopEngaged(panel, id);
  const StopId given = robot_.EngageEmergencyStop(id, panel, by);
  if (id != 0) return;
  checker_.OnStopEngaged(panel, given);
  if (other_) other_->checker().OnStopEngaged(panel, given);
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

// What is around the robot.
void Scenario::ApplyAround(const Injection& injection) {
  switch (injection.kind) {
    case InjectionKind::kOtherMachine:
      return MeetOtherMachine(injection);
    case InjectionKind::kOuterNetwork:
      robot_.hosts().SetCutOff(injection.host, true);
      return Later(injection.lasts,
                   [this, host = injection.host] { robot_.hosts().SetCutOff(host, false); });
    case InjectionKind::kLostFiles:
      checker_.OnControllersBlocked(true);
      robot_.LoseFiles();
      return Later(std::chrono::seconds(1), [this] { robot_.SaveAgain(); });
    case InjectionKind::kBridge:
      bridge_ = std::make_unique<Bridge>(robot_.network(), config_, injection.random);
      return Later(injection.lasts, [this] { bridge_.reset(); });
    case InjectionKind::kStopProgram:
      EngageByProgram(injection);
      return ReleaseLater(injection);
    case InjectionKind::kManyStops:
      EngageMany(transport::sim::Random(injection.random));
      return ReleaseLater(injection);
    default:
      Engage(injection.random / 2 % 2, 0);
      return ReleaseLater(injection);
  }
}

void Scenario::ReleaseLater(const Injection& injection) {
  if (injection.lasts == Duration::zero()) return;
  Later(injection.lasts, [this, host = injection.host, by_client = injection.random % 3 == 0] {
    if (!by_client) return robot_.ReleaseEmergencyStop();
    robot_.ClientOn(host).ReleaseEmergencyStop();
  });
}

// It starts before it comes into range, or just then; meanwhile people use it. Half of them stay.
void Scenario::MeetOtherMachine(const Injection& injection) {
  if (other_) return;
  transport::sim::Random random(injection.random);
  const std::size_t host = robot_.hosts().size() - 1;
  other_ = std::make_unique<OtherMachine>(robot_, checker_, host, random);
  for (std::size_t number = 0; number < program_stops_.size(); ++number) NoteForOther(number);
  other_->on_record = [this](action::Record record) {
    record.message = "other machine: " + record.message;
    Mix(record.message);
    if (listener.on_record) listener.on_record(robot_.network().now(), record);
  };
  ApplyNetworkFaults();
  const Duration alone =
      random.Bernoulli(0.3) ? Duration::zero() : random.Between({}, std::chrono::seconds(5));
  Later(alone, [this] { other_->SetInRange(true); });
  for (std::uint64_t acts = random.Next() % 5; acts > 0; --acts) {
    Later(random.Between({}, alone + injection.lasts), [this] { other_->Act(); });
  }
  const bool stays = random.Bernoulli(0.5);
  Later(alone + injection.lasts, [this, stays] {
    if (!stays) other_->SetInRange(false);
    other_->StartController(true);  // where none runs
  });
}

void Scenario::EngageByProgram(const Injection& injection) {
  // As late as the stop may arrive, over links that lose most of it.
  constexpr Duration kLatest = std::chrono::seconds(30);
  transport::sim::Random random(injection.random);
  const std::array<Duration, 3> delays = {Milliseconds(1), Milliseconds(100), Milliseconds(400)};
  const std::array<Duration, 3> discoveries = {Milliseconds(5), Milliseconds(1500),
                                               std::chrono::seconds(10)};
  SimRobot::StopLinks links;
  links.delay_most = delays[random.Next() % delays.size()];
  links.discovery_most = discoveries[random.Next() % discoveries.size()];
  links.loss = random.Bernoulli(0.5) ? 0.3 : 0;
  const StopId id((random.Next() | 1) >> 1);
  checker_.OnStopEngaged(kFirstProgram + program_stops_.size(), id);
  robot_.on_stop_program = [this](StopId stop, bool confirmed) {
    ++ending_.stop_programs[confirmed ? 1 : 0];
    const auto program = std::find_if(program_stops_.begin(), program_stops_.end(),
                                      [&](const ProgramStop& one) { return one.id == stop; });
    // It has not named this machine: it may reach and confirm the other one alone.
    const bool any = other_ && program->meant.name.empty();
    if (confirmed && !any) checker_.OnStopConfirmed(stop);
  };
  robot_.on_stop_withdrawn = [this](StopId stop) { checker_.OnStopWithdrawn(stop); };
  const MachineIdentity meant =
      robot_.EngageByProgram(id, injection.host, links, random.Bernoulli(0.2));
  Later(kLatest, [] {});
  program_stops_.push_back({id, meant});
  if (other_) NoteForOther(program_stops_.size() - 1);
}

// Whether the stop is meant for the other machine as well, which may be out of range.
void Scenario::NoteForOther(std::size_t number) {
  const ProgramStop& stop = program_stops_[number];
  Checker& checker = other_->checker();
  if (!SameMachine(stop.meant, other_->robot().identity())) return checker.OnStopOfOther(stop.id);
  checker.OnStopEngaged(kFirstProgram + number, stop.id);
  checker.OnStopWithdrawn(stop.id);
}

// By one source or by as many, with or without ids.
void Scenario::EngageMany(transport::sim::Random random) {
  const int count = 20 + static_cast<int>(random.Next() % 80);
  const StopId first(random.Bernoulli(0.3) ? 0 : (random.Next() >> 8) + 1);
  EngageNext(random.Next() % 2, first, random.Bernoulli(0.5), count);
}

void Scenario::EngageNext(std::size_t panel, StopId id, bool one_source, int left) {
  if (left == 0) return;
  Engage(panel, id, one_source ? "a person" : "person " + std::to_string(left));
  const StopId next(id == 0 ? 0 : id.value() + 1);
  Later(Milliseconds(1 + left % 20),
        [this, panel, next, one_source, left] { EngageNext(panel, next, one_source, left - 1); });
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
  const bool any = std::any_of(network_faults_.begin(), network_faults_.end(),
                               [](int active) { return active > 0; });
  checker_.OnLinkFaults(any);
  if (other_) other_->checker().OnLinkFaults(any);
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
