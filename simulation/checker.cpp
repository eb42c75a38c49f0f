#include "musher/simulation/checker.hpp"

#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/lifecycle/machine/machine_invariants.hpp"

namespace musher::simulation {

Checker::Checker(SimRobot& robot) : context_(robot), robot_(robot), config_(robot.config()) {
  robot_.on_input = [this] { dirty_ = true; };
  robot_.on_send = [this](const Machine& machine, const action::SendSwitch& send) {
    commands_.OnSend(machine, send);
    holds_.OnSend(machine, send);
  };
  robot_.on_start = [this](const SimulatedController& controller, const std::string& name) {
    ++checks_;
    processes_.OnStart(controller, name);
    tear_down_.OnStart(controller, name);
    tear_down_.CheckMayStart(controller, name);
  };
  robot_.processes().on_report = [this](const std::string& name, std::size_t host,
                                        const ActuatorReport& report) {
    OnReport(name, host, report);
  };
  robot_.on_write = [this](const SimulatedController& controller, const std::string& topic,
                           const msg::Bytes& bytes) { OnWrite(controller, topic, bytes); };
  robot_.on_signal = [this](const SimulatedController& controller, std::int32_t pid) {
    processes_.CheckSignal(controller, pid);
    processes_.CheckKill(controller, pid);
  };
  if (SimulatedSystemds* systemds = robot_.systemds()) {
    systemds->on_wrong_process = [this](const std::string& name) {
      ReportViolation(Invariant::kOnlyOwnProcessesSignalled,
                      "a signal to an earlier process of " + name + " reaches the one after it");
    };
  }
  robot_.on_record_of = [this](const SimulatedController& controller,
                               const action::Record& record) {
    policy_.OnRecord(controller, record);
    authority_.NoteReasons(controller, record);
    release_.NoteRequest(controller, record);
    policy_time_.CheckPolicyTime(controller, record);
    authority_.CheckMeant(record);
    authority_.CheckFence(controller, record);
  };
  robot_.on_power = [this] { policy_.ForgetPowerOff(); };
  robot_.on_battery = [this](int percent, bool charging) { policy_.OnBattery(percent, charging); };
  robot_.on_permit = [this](Time stamp) { stops_.OnPermit(stamp); };
  robot_.on_clock = [this](Time time) { policy_time_.OnClock(time); };
  robot_.on_motion = [this](std::int32_t motion) { policy_time_.OnMotion(motion); };
  robot_.on_begin = [this](const SimulatedController& controller, Starter starter) {
    // A person has switched the host on, perhaps: a boot begins the machine, and undoes nothing.
    if (starter != Starter::kSupervisor) tear_down_.OnPersonsStart();
    if (starter == Starter::kPerson) tear_down_.OnBegunByPerson(controller);
    holds_.OnBegin(controller, starter);
    release_.OnBegin(controller, starter != Starter::kPerson);
    authority_.NoteWord(controller, starter != Starter::kPerson);
  };
  robot_.on_release_answered = [this](const SimulatedController& controller,
                                      const Result<>& released) {
    stops_.CheckReleased(controller, released);
  };
}

void Checker::OnWrite(const SimulatedController& controller, const std::string& topic,
                      const msg::Bytes& bytes) {
  if (topic.starts_with("rr/")) return switches_.OnReplyWritten(controller, topic.substr(3));
  if (!topic.ends_with("musher/emergency_stop")) return;
  if (const auto stop = msg::Decode<msg::EmergencyStop>(bytes)) {
    stops_.OnStopPublished(controller, *stop);
  }
}

void Checker::OnReport(const std::string& name, std::size_t host, const ActuatorReport& report) {
  ++checks_;
  ActuatorReport& before = context_.reports[{name, report.host}];
  if (before.incarnation != report.incarnation) before = ActuatorReport{};
  if (report.epoch < before.epoch || report.number < before.number) {
    ReportViolation(Invariant::kNoStaleCommand, name + " goes back to epoch " +
                                                    ToString(report.epoch) + ", command " +
                                                    ToString(report.number));
  }
  const bool begun = report.busy() && (!before.busy() || before.target != report.target ||
                                       before.busy_number != report.busy_number);
  if (begun) commands_.OnBegun(name, host, before, report);
  if (before.busy() && !report.busy()) authority_.NoteEnded(name, host, report);
  processes_.NoteOverrun(name, host, begun, report);
  authority_.CheckFollows(name, host, report);
  if (const ActuatorCore* core = robot_.processes().CoreOf(name, host)) {
    authority_.CheckControllerOf(name, core->controller);
    stops_.NotePermitStops(*core);
  }
  stops_.CheckStaysStopped(name, before, report);
  stops_.CheckStopped(name, host, before, report);
  commands_.CheckWaiting(name, host, report);
  if (report.state != kTearDown) tear_down_.OnStarted(name);
  before = report;
}

void Checker::AfterEvent() {
  policy_.CheckPowerOff();
  stops_.CheckPower();
  stops_.CheckPermits();
  switches_.CheckClients();
  user_rules_.AfterEvent();
  if (!dirty_) return;
  dirty_ = false;
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* controller = robot_.controller(which);
    if (controller == nullptr || !controller->leads()) continue;
    if (controller->frozen) {
      over_since_.erase(controller->serial());
      continue;
    }
    ++checks_;
    CheckController(*controller);
  }
  switches_.ForgetReplied();
}

void Checker::CheckController(const SimulatedController& controller) {
  const Machine& machine = controller.shell().machine();
  if (const std::string broken = BrokenInvariant(config_, machine); !broken.empty()) {
    ReportViolation(Invariant::kMachineIsConsistent, broken);
  }
  CheckDeadline(controller);
  tear_down_.NoteReceived(controller);
  holds_.NoteSwitch(controller);
  const Epoch epoch = authority_.CheckEpoch(controller);
  if (epoch != 0 && epoch != machine.epoch) {
    commands_.CarryCommandsOver(controller.serial(), epoch, machine.epoch);
  }
  rest_.NotePresence(controller);
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const bool present = machine.actuators[i].presence == Presence::kPresent;
    if (!present && !machine.actuators[i].command) commands_.NoteGivenUp(machine.epoch, i);
  }
  authority_.CheckReason(controller, switches_.StateOf(controller));
  switches_.CheckChange(controller);
  policy_.CheckCeiling(controller, false);
  policy_.CheckQuiet(controller);
  policy_time_.NotePolicyTimes(controller);
  tear_down_.CheckStaysDown(controller);
}

// Other events of the same instant may come before the deadline: a step of another controller, or
// the stops that a panel engages by the hundred.
void Checker::CheckDeadline(const SimulatedController& controller) {
  constexpr int kOthers = 10'000;
  const Time now = robot_.network().now();
  const auto deadline = NextDeadline(config_, controller.shell().machine());
  if (!deadline || *deadline > controller.Now()) {
    over_since_.erase(controller.serial());
    return;
  }
  const auto since = over_since_.try_emplace(controller.serial(), now, 0).first;
  if (now > since->second.first || ++since->second.second > kOthers) {
    ReportViolation(Invariant::kNoPastDeadline,
                    "a deadline of the controller has passed and is still its next");
  }
}

void Checker::OnLinkFaults(bool active) {
  if (active) {
    context_.link_faults_until = Time::max();
  } else if (context_.link_faults_until == Time::max()) {
    context_.link_faults_until = robot_.network().now();
  }
}

std::uint64_t Checker::OnRequest(const SimulatedController& controller, const State& target) {
  return switches_.OnRequest(controller, target);
}

void Checker::OnReply(std::uint64_t request, const SwitchResult& result) {
  ++checks_;
  switches_.OnReply(request, result);
}

void Checker::OnRecord(const action::Record& record) {
  switch (record.event) {
    case EventName::kRestartRequested:
      processes_.ForgetWrongConfig(config_.actuators[*record.actuator].name);
      tear_down_.OnStarted(config_.actuators[*record.actuator].name);
      break;
    case EventName::kPolicyRequested:
    case EventName::kSwitchRequested:
      // A request that ends in the same step never shows as the switch under way.
      if (!record.actuator && !TargetOf(record).empty()) switches_.NoteReplied(TargetOf(record));
      break;
    default:
      break;
  }
}

std::uint64_t Checker::OnPolicyRequest(const SimulatedController& controller,
                                       const event::PolicyRequested& requested) {
  const bool up = requested.what == PolicyRequest::kWakeUp ||
                  (requested.what == PolicyRequest::kOta && !requested.enable) ||
                  (requested.what == PolicyRequest::kLowPowerSwitch && !requested.enable);
  if (up) policy_.OnRaiseRequest();
  release_.OnPolicyRequest(controller, up);
  return OnRequest(controller,
                   requested.what == PolicyRequest::kKeep ? requested.state : State(kActive));
}

void Checker::OnPolicyReply(std::uint64_t request, const event::PolicyRequested& requested,
                            const Result<>& reply) {
  ++checks_;
  if (switches_.OnPolicyReply(request, requested) && reply) policy_.OnAccepted(requested);
}

void Checker::OnControllersBlocked(bool state_lost) {
  policy_.ForgetPowerOff();
  context_.state_lost |= state_lost;
}

void Checker::OnControllerKilled(const SimulatedController& controller) {
  OnControllersBlocked(false);
  switches_.OnControllerKilled(controller);
}

void Checker::OnStopConfirmed(StopId id) {
  ++checks_;
  stops_.OnStopConfirmed(id);
}

void Checker::CheckRest(bool provided) {
  const SimulatedController* controller = robot_.leader();
  if (controller == nullptr) return;
  ++checks_;
  const Machine& machine = controller->shell().machine();
  switches_.CheckAtRest();
  policy_.CheckCeiling(*controller, true);
  if (machine.phase != Phase::kStopped) {
    stops_.CheckStopsAtRest(machine);
    switches_.CheckClientsAtRest();
  }
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    if (machine.phase == Phase::kStopped) {
      const std::string& name = config_.actuators[i].name;
      const bool here = robot_.processes().IsAlive(name, controller->host());
      if (!config_.actuators[i].command.empty() && here) {
        ReportViolation(Invariant::kTearDownEndsProcesses,
                        "the process of " + name + " outlives the machine");
      }
      const bool unit = !config_.actuators[i].host.empty();
      if (unit && robot_.IsAlive(name) && !machine.actuators[i].fault) {
        ReportViolation(Invariant::kTearDownEndsProcesses,
                        "the unit of " + name + " outlives the machine, which names no reason");
      }
      continue;
    }
    rest_.CheckPlaceInStart(machine, i);
    if (machine.phase != Phase::kRunning) continue;
    processes_.CheckRunsOnce(config_.actuators[i].name);
    rest_.CheckPlace(machine, i);
    rest_.CheckLoss(machine, i, provided);
  }
  user_rules_.CheckAtRest(machine);
}

}  // namespace musher::simulation
