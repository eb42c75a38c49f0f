// What incidents do to the robot, and what people do to repair it.

#include <signal.h>

#include <algorithm>

#include "musher/simulation/story.hpp"
#include "musher/simulation/way.hpp"

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
      judge_.PersonStarts();
      return robot_.StartRival(false);
    case IncidentKind::kTakeover:
      judge_.PersonStarts();
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

// People come: they release the stop, start again what nothing else does, and bring the machine
// back to where it is of use.
void Story::Repair() {
  if (config_.policy) {
    Note("people charge the battery");
    robot_.SetBattery(100, true);
    RunFor(std::chrono::seconds(2));
    if (!ComeToRest("after the charge")) return;
  }
  if (robot_.machine().phase == Phase::kStopped) {
    Note("the machine was torn down; it is started anew");
    robot_.CrashController();
    for (std::size_t i = 0; i < config_.actuators.size(); ++i) {
      if (!IsByHand(i)) continue;
      robot_.CrashActuator(config_.actuators[i].name);
      StartByHand(i);
    }
    StartController();
    if (!ComeToRest("after its start")) return;
  }
  for (int tries = 0; tries < 8 && robot_.machine().emergency_stop; ++tries) {
    Note("people release the emergency stop");
    robot_.ReleaseEmergencyStop();
    RunFor(std::chrono::seconds(1));  // another one may have been engaged beside it
    if (Over() || !ComeToRest("after the release")) return;
  }
  RepairActuators();
  if (!ComeToRest("after its repair")) return;
  if (BringHome() && !Over()) JudgeWhole();
}

bool Story::ComeToRest(const std::string& when) {
  RunUntil([this] { return judge_.AtRest(); }, options_.bound);
  if (!judge_.AtRest()) {
    judge_.Blame(Promise::kComesToRest,
                 "the machine is not at rest " + when + ": " + judge_.Unrest());
  }
  return !Over();
}

void Story::RepairActuators() {
  if (EndSurplus()) RunFor(std::chrono::seconds(2));
  const auto* leader = robot_.leader();
  for (std::size_t i = 0; i < config_.actuators.size() && leader != nullptr; ++i) {
    const std::size_t process = robot_.layout().ProcessOf(i);
    const ActuatorConfig& actuator = config_.actuators[process];
    const ActuatorRecord& record = leader->shell().machine().actuators[i];
    const ActuatorReport* report = robot_.ReportOf(i, record.report);
    const bool well = report != nullptr && !report->busy() && !record.fault;
    if (well) continue;
    Note("people restart " + actuator.name);
    EndElsewhere(actuator);
    if (!actuator.command.empty()) {
      judge_.AskedRestart(actuator.name);
      robot_.Restart(actuator.name);
      continue;
    }
    robot_.CrashActuator(actuator.name);
    RunFor(std::chrono::seconds(1));
    if (Over()) return;
    StartByHand(process);
  }
  RunFor(std::chrono::seconds(15));
}

// What runs on another host than its controller is ended there.
void Story::EndElsewhere(const ActuatorConfig& actuator) {
  const std::size_t here = robot_.leader()->host();
  for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
    if (actuator.command.empty() || host == here) continue;
    if (!robot_.processes().IsAlive(actuator.name, host)) continue;
    robot_.processes().End(actuator.name, host, {ProcessExit::Kind::kKilled, SIGKILL});
    RunFor(std::chrono::seconds(12));  // until that is known: nobody there watches it
  }
}

// Of an actuator that runs on several hosts people leave the one that the controller can restart.
bool Story::EndSurplus() {
  bool any = false;
  const std::size_t here = robot_.leader()->host();
  for (const ActuatorConfig& actuator : config_.actuators) {
    const bool by_controller =
        !actuator.command.empty() && robot_.processes().IsAlive(actuator.name, here);
    const std::size_t keep = by_controller ? here : robot_.processes().HomeOf(actuator.name);
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const bool surplus = host != keep && robot_.processes().CountOf(actuator.name) > 1;
      if (!surplus || !robot_.processes().IsAlive(actuator.name, host)) continue;
      Note("people end " + actuator.name + " on host " + robot_.hosts().name(host));
      robot_.processes().End(actuator.name, host, {ProcessExit::Kind::kKilled, SIGKILL});
      any = true;
    }
  }
  return any;
}

bool Story::BringHome() {
  for (int tries = 0; tries < 3; ++tries) {
    const ControllerProcess* leader = robot_.leader();
    if (leader == nullptr) {
      judge_.Blame(Promise::kComesToRest, "nobody leads the machine");
      return false;
    }
    const State from = leader->shell().machine().state;
    auto way = FindWay(config_, from, options_.home);
    if (!way) {
      judge_.Blame(Promise::kWayBack, "the machine is in " + from +
                                          ", from where no switch leads to " + options_.home);
      return false;
    }
    // A check by hand takes along those that had failed theirs.
    if (config_.HasState(kSelfCheck)) way->insert(way->begin(), State(kSelfCheck));
    if (way->size() < 2 && from == options_.home) way->push_back(options_.home);
    for (const State& next : *way) {
      Note("people ask for " + next);
      Ask(next);
      RunUntil([this] { return judge_.AtRest(); }, options_.bound);
      RunFor(std::chrono::seconds(2));
      if (Over()) return false;
    }
    const Machine& machine = robot_.machine();
    if (machine.state == options_.home && Degraded(config_, machine).empty()) return true;
  }
  return true;
}

void Story::JudgeWhole() {
  const Machine& machine = robot_.machine();
  if (machine.state != options_.home) {
    return judge_.Blame(Promise::kWholeAgain, "repaired and asked for " + options_.home +
                                                  ", the machine is in " + machine.state);
  }
  const auto degraded = Degraded(config_, machine);
  if (!degraded.empty()) {
    const std::size_t i = *config_.IndexOf(degraded.front());
    return judge_.Blame(Promise::kWholeAgain,
                        "after the repair " + degraded.front() +
                            " is still degraded: " + machine.actuators[i].fault->message);
  }
  judge_.JudgeRest(false);
  for (const ActuatorConfig& actuator : config_.actuators) {
    const std::size_t i = *config_.IndexOf(actuator.name);
    const ActuatorReport* report = robot_.ReportOf(i, machine.actuators[i].report);
    const std::string state = report == nullptr ? "gone" : "in " + report->state;
    if (report == nullptr || report->state != options_.home) {
      judge_.Blame(Promise::kWholeAgain, "after the repair " + actuator.name + " is " + state);
    }
  }
}

void Story::SwitchOff() {
  if (!config_.HasState(kTearDown)) return;
  Note("people switch the robot off");
  Ask(State(kTearDown));
  const auto stopped = [this] { return robot_.machine().phase == Phase::kStopped; };
  if (!RunUntil(stopped, config_.shutdown_budget + Milliseconds(100))) {
    return judge_.Blame(Promise::kEndsWhenAsked, "the machine is not torn down within its budget");
  }
  RunFor(Milliseconds(100));
  judge_.JudgeRest(false);
}

StoryOptions UsualOptions(const MachineConfig& config) {
  StoryOptions options;
  Duration longest{};
  Duration delay{};
  int restarts = 1;
  for (std::size_t i = 0; i < config.actuators.size(); ++i) {
    Duration one{};
    for (const State& state : config.actuators[i].states) {
      one = std::max(one, config.TimeFor(i, state));
    }
    longest += one;  // as if all came after each other
    restarts = std::max(restarts, config.actuators[i].restart.limit);
    delay = std::max(delay, config.actuators[i].restart.max_delay);
  }
  options.bound = std::chrono::minutes(1) + 3 * (restarts + 1) * (longest + delay);
  for (const State& state : config.states) {
    const auto rank = config.RankOf(state);
    const bool higher = rank && (options.home.empty() || *rank > *config.RankOf(options.home));
    if (higher) options.home = state;
  }
  if (config.HasState(kActive)) options.home = State(kActive);
  return options;
}

}  // namespace musher::simulation
