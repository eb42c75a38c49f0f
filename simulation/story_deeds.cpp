// What incidents do to the robot.

#include <algorithm>

#include "musher/simulation/story.hpp"

namespace musher::simulation {

using transport::sim::LinkFaults;

namespace {

constexpr std::int32_t kLying = 0;
constexpr std::int32_t kWalking = 303;

}  // namespace

void Story::Do(const Incident& incident) {
  const std::string& name = config_.actuators[incident.actuator].name;
  const Time now = robot_.network().now();
  Mood& mood = moods_[incident.actuator];
  switch (incident.kind) {
    case IncidentKind::kCrash:
      return robot_.CrashActuator(name);
    case IncidentKind::kWrongConfig:
      return Misconfigure(name, incident.lasts);
    case IncidentKind::kFreeze:
      if (!robot_.IsAlive(name)) return;
      robot_.FreezeActuator(name);
      return Later(incident.lasts, [this, name] {
        if (robot_.IsAlive(name)) robot_.ThawActuator(name);
      });
    case IncidentKind::kHang:
      mood.hangs = now + incident.lasts;
      return;
    case IncidentKind::kSlow:
      mood.slow = now + incident.lasts;
      return;
    case IncidentKind::kFail:
      mood.fails = now + incident.lasts;
      return;
    case IncidentKind::kLie:
      if (!robot_.IsAlive(name)) return;
      judge_.Lied(name);
      return robot_.Lie(name, incident.state);
    case IncidentKind::kSet:
      return Ask(incident.state);
    case IncidentKind::kSetOne:
      return Ask(incident.state, name);
    case IncidentKind::kBattery:
      return robot_.SetBattery(BatteryOf(incident), ChargesIn(incident));
    case IncidentKind::kEmergencyStop:
      return Engage(incident.chance / 2 % 2, incident.chance | 1);
    case IncidentKind::kRelease:
      return robot_.ReleaseEmergencyStop();
    case IncidentKind::kRestart:
      judge_.AskedRestart(name);
      return robot_.Restart(name);
    default:
      if (incident.kind >= IncidentKind::kClientSet) return DoByClient(incident);
      if (incident.kind == IncidentKind::kCrossingStops) return DoToStops(incident);
      if (incident.kind == IncidentKind::kStalledDisk) return DoToController(incident);
      if (incident.kind >= IncidentKind::kReboot) return DoToHosts(incident);
      if (incident.kind > IncidentKind::kRestart) return DoToPolicy(incident);
      return incident.kind < IncidentKind::kControllerCrash ? DoToNetwork(incident)
                                                            : DoToController(incident);
  }
}

void Story::Misconfigure(const std::string& name, Duration lasts) {
  robot_.processes().Misconfigure(name, true);
  if (robot_.IsAlive(name)) {
    judge_.FindsConfigWrong(name);
    robot_.processes().End(name, WrongConfigExit());
  }
  Later(lasts, [this, name] { robot_.processes().Misconfigure(name, false); });
}

void Story::DoToPolicy(const Incident& incident) {
  const std::uint64_t chance = incident.chance;
  switch (incident.kind) {
    case IncidentKind::kStillness:
      return robot_.SetMotion(chance % 4 == 0 ? kWalking : kLying);
    case IncidentKind::kWakeUp:
      return AskPolicy({0, PolicyRequest::kWakeUp, "", 0, false});
    case IncidentKind::kKeep:
      return AskPolicy(
          {0, PolicyRequest::kKeep, incident.state, static_cast<std::int64_t>(chance % 8), false});
    case IncidentKind::kOta:
      return AskPolicy({0, PolicyRequest::kOta, "", 0, chance % 2 == 0});
    case IncidentKind::kLowPowerSwitch:
      return AskPolicy({0, PolicyRequest::kLowPowerSwitch, "", 0, chance % 3 != 0});
    default:
      return AskPolicy({0, PolicyRequest::kPowerOff, "", 0, false});
  }
}

void Story::AskPolicy(const event::PolicyRequested& asked) {
  ControllerProcess* leader = robot_.leader();
  if (leader == nullptr || leader->frozen) return;
  const std::uint64_t request = judge_.AskedPolicy(*leader, asked);
  leader->shell().AskPolicy(asked, [this, request, asked](const Result<>& answer) {
    Mix(answer ? "ok" : answer.error().message);
    judge_.AnsweredPolicy(request, asked, answer);
  });
}

void Story::DoToNetwork(const Incident& incident) {
  if (incident.kind < IncidentKind::kPartition) {
    const auto which =
        static_cast<std::size_t>(incident.kind) - static_cast<std::size_t>(IncidentKind::kLoss);
    ++network_troubles_[which];
    ApplyNetworkFaults();
    return Later(incident.lasts, [this, which] {
      --network_troubles_[which];
      ApplyNetworkFaults();
    });
  }
  const bool deaf = incident.kind != IncidentKind::kMute;
  const bool mute = incident.kind != IncidentKind::kDeaf;
  const std::size_t process = robot_.layout().ProcessOf(incident.actuator);
  const auto set = [this, name = config_.actuators[process].name, deaf, mute](bool blocked) {
    for (const char* controller : SimRobot::kControllerEndpoints) {
      if (deaf) robot_.hosts().SetBlocked(controller, name, blocked);
      if (mute) robot_.hosts().SetBlocked(name, controller, blocked);
    }
  };
  set(true);
  Later(incident.lasts, [set] { set(false); });
}

void Story::Engage(std::size_t panel, std::uint64_t id) {
  judge_.StopEngaged(panel, id);
  robot_.EngageEmergencyStop(id, panel);
}

// Two panels engage a stop, and a release comes between or about the same time.
void Story::DoToStops(const Incident& incident) {
  const std::uint64_t chance = incident.chance;
  const std::size_t panel = chance / 2 % 2;
  Engage(panel, chance | 1);
  Later(Milliseconds(static_cast<std::int64_t>(chance / 16 % 40)),
        [this, panel, id = (chance >> 9) | 1] { Engage(1 - panel, id); });
  Later(Milliseconds(static_cast<std::int64_t>(chance / 1024 % 60)),
        [this] { robot_.ReleaseEmergencyStop(); });
}

void Story::DoByClient(const Incident& incident) {
  Client& client = robot_.ClientOn(incident.host);
  client.on_end = [this](const Client::Request&, const SwitchEnd& end) {
    ++ending_.client_ends[static_cast<std::size_t>(end.kind)];
    Mix(end.result.outcome);
  };
  client.on_answer = [this](bool answered) { ++ending_.client_calls[answered ? 1 : 0]; };
  const std::string& name = config_.actuators[incident.actuator].name;
  switch (incident.kind) {
    case IncidentKind::kClientSet:
      judge_.ClientAsks(incident.state);
      return client.SetState(incident.state, incident.chance % 8 == 0 ? name : "");
    case IncidentKind::kClientRelease:
      return client.ReleaseEmergencyStop();
    case IncidentKind::kClientRestart:
      judge_.AskedRestart(name);
      return client.Restart(name);
    default:
      return client.GetStatus();
  }
}

void Story::DoToHosts(const Incident& incident) {
  const std::size_t from = incident.host;
  const std::size_t to = incident.other_host;
  if (incident.kind == IncidentKind::kReboot) return Reboot(from, incident.lasts);
  const auto set = [this, from, to,
                    both = incident.kind == IncidentKind::kHostPartition](bool blocked) {
    robot_.hosts().SetHostBlocked(from, to, blocked);
    if (both) robot_.hosts().SetHostBlocked(to, from, blocked);
  };
  set(true);
  Later(incident.lasts, [set] { set(false); });
}

// What a person or the host's own start-up had started comes back with the host.
void Story::Reboot(std::size_t host, Duration lasts) {
  bool had_controller = false;
  for (std::size_t which = 0; which < 2; ++which) {
    const ControllerProcess* controller = robot_.controller(which);
    had_controller |= controller != nullptr && controller->host() == host;
  }
  robot_.RebootHost(host);
  Later(lasts, [this, host, had_controller] {
    for (std::size_t i = 0; i < config_.actuators.size(); ++i) {
      if (IsByHand(i) && robot_.layout().HostOf(i) == host) StartByHand(i);
    }
    const bool none = !robot_.has_controller() && robot_.controller(0) == nullptr;
    const bool here = robot_.layout().controllers[0] == host;
    if (had_controller && none) StartController(supervised_ && here);
  });
}

void Story::ApplyNetworkFaults() {
  LinkFaults faults;
  if (network_troubles_[0] > 0) faults.loss = 0.2;
  if (network_troubles_[1] > 0) faults.delay_max = Milliseconds(80);
  if (network_troubles_[2] > 0) faults.duplication = 0.3;
  if (network_troubles_[3] > 0) faults.reordering = 0.3;
  robot_.network().SetFaults(faults);
}

void Story::DoToController(const Incident& incident) {
  if (incident.kind != IncidentKind::kWallClock) {
    judge_.ControllersHindered(incident.kind == IncidentKind::kFullDisk ||
                               incident.kind == IncidentKind::kStalledDisk);
  }
  switch (incident.kind) {
    case IncidentKind::kControllerCrash: {
      // A supervisor restarts what has crashed on its host.
      const bool restarted = supervised_ && (robot_.controller(0) != nullptr || robot_.OneHost());
      robot_.CrashController();
      return Later(incident.lasts, [this, restarted] {
        if (!robot_.has_controller() && robot_.controller(0) == nullptr) StartController(restarted);
      });
    }
    case IncidentKind::kStalledDisk:
      robot_.StallDisk(true);
      return Later(incident.lasts, [this] { robot_.StallDisk(false); });
    case IncidentKind::kControllerFreeze:
      robot_.FreezeController();
      return Later(incident.lasts, [this] { robot_.ThawController(); });
    case IncidentKind::kRival:
      return robot_.StartRival(false);
    case IncidentKind::kTakeover:
      return robot_.StartRival(true);
    case IncidentKind::kFullDisk:
      robot_.FillDisk(true);
      return Later(incident.lasts, [this] { robot_.FillDisk(false); });
    default:
      return robot_.JumpWallClock(
          Milliseconds(static_cast<std::int64_t>(incident.chance % 7'200'000)) -
          std::chrono::hours(1));
  }
}

void Story::Ask(const State& target, const std::optional<std::string>& actuator) {
  ControllerProcess* leader = robot_.leader();
  if (leader == nullptr || leader->frozen) return;
  const std::uint64_t request = judge_.Asked(*leader, target);
  leader->shell().SetState(target, actuator, [this, request](const SwitchResult& result) {
    ++ending_.switches[static_cast<std::size_t>(result.outcome)];
    Mix(std::string(OutcomeName(result.outcome)));
    judge_.Answered(request, result);
  });
}

}  // namespace musher::simulation
