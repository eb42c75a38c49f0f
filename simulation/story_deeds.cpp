// What incidents do to the robot, and what people do to repair it.

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
      return robot_.EngageEmergencyStop(incident.chance | 1);
    case IncidentKind::kRelease:
      return robot_.ReleaseEmergencyStop();
    case IncidentKind::kRestart:
      judge_.AskedRestart(name);
      return robot_.Restart(name);
    default:
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
  const std::uint64_t request = judge_.AskedPolicy(asked);
  leader->shell().AskPolicy(asked, [this, request, asked](const Result<>& answer) {
    Mix(answer ? "ok" : answer.error().message);
    judge_.AnsweredPolicy(request, asked, answer);
  });
}

void Story::DoToNetwork(const Incident& incident) {
  const std::string& name = config_.actuators[incident.actuator].name;
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
  const auto set = [this, name, deaf, mute](bool blocked) {
    for (const char* host : SimRobot::kControllerHosts) {
      if (deaf) SetDistance(host, name, blocked);
      if (mute) SetDistance(name, host, blocked);
    }
  };
  set(true);
  Later(incident.lasts, [set] { set(false); });
}

void Story::SetDistance(const std::string& from, const std::string& to, bool blocked) {
  int& count = blocks_[{from, to}];
  count += blocked ? 1 : -1;
  if (count == 0) robot_.network().Free(from, to);
  if (count == 1 && blocked) robot_.network().Block(from, to);
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
    judge_.ControllersHindered(incident.kind == IncidentKind::kFullDisk);
  }
  switch (incident.kind) {
    case IncidentKind::kControllerCrash:
      robot_.CrashController();
      judge_.ControllersEnded();
      return Later(incident.lasts, [this] {
        if (!robot_.has_controller() && robot_.controller(0) == nullptr) robot_.StartController();
      });
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
  const std::uint64_t request = judge_.Asked(target);
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
    for (const ActuatorConfig& actuator : config_.actuators) {
      if (!actuator.command.empty()) continue;
      robot_.CrashActuator(actuator.name);
      robot_.StartActuator(actuator.name);
    }
    robot_.StartController();
    if (!ComeToRest("after its start")) return;
  }
  if (robot_.machine().emergency_stop) {
    Note("people release the emergency stop");
    robot_.ReleaseEmergencyStop();
    if (!ComeToRest("after the release")) return;
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
  const auto* leader = robot_.leader();
  for (std::size_t i = 0; i < config_.actuators.size() && leader != nullptr; ++i) {
    const ActuatorConfig& actuator = config_.actuators[i];
    const ActuatorRecord& record = leader->shell().machine().actuators[i];
    const ActuatorReport* report = robot_.processes().ReportOf(actuator.name);
    const bool well = report != nullptr && !report->busy() && !record.fault;
    if (well) continue;
    Note("people restart " + actuator.name);
    if (!actuator.command.empty()) {
      judge_.AskedRestart(actuator.name);
      robot_.Restart(actuator.name);
      continue;
    }
    robot_.CrashActuator(actuator.name);
    RunFor(std::chrono::seconds(1));
    if (Over()) return;
    if (!robot_.IsAlive(actuator.name)) robot_.StartActuator(actuator.name);
  }
  RunFor(std::chrono::seconds(15));
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
    const ActuatorReport* report = robot_.processes().ReportOf(actuator.name);
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
