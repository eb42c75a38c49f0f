#include "musher/simulation/checker.hpp"

#include <algorithm>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/lifecycle/machine/machine_invariants.hpp"

namespace musher::simulation {
namespace {

// How much older than its budget a command may be when it begins: the clocks of two hosts are
// compared by the report with the shortest transit time.
constexpr Duration kClockSlack = Milliseconds(100);

bool IsRequested(const Switch& s) {
  return s.purpose == Purpose::kRequested || s.purpose == Purpose::kStartUpActivate ||
         s.purpose == Purpose::kStartUpCheck;
}

}  // namespace

Checker::Checker(SimRobot& robot)
    : robot_(robot), config_(robot.config()), lost_at_(config_.actuators.size()) {
  robot_.on_input = [this] { dirty_ = true; };
  robot_.on_send = [this](const Machine& machine, const action::SendSwitch& send) {
    OnSend(machine, send);
  };
  robot_.on_start = [this](const ControllerProcess& controller, const std::string& name) {
    OnStart(controller, name);
  };
  robot_.processes().on_report = [this](const std::string& name, std::size_t host,
                                        const ActuatorReport& report) {
    OnReport(name, host, report);
  };
  robot_.on_write = [this](const ControllerProcess& controller, const std::string& topic,
                           const msg::Bytes& bytes) { OnWrite(controller, topic, bytes); };
  robot_.on_signal = [this](const ControllerProcess& controller, std::int32_t pid) {
    CheckSignal(controller, pid);
    CheckKill(controller, pid);
  };
  robot_.on_record_of = [this](const ControllerProcess& controller, const action::Record& record) {
    recording_host_ = controller.host();
    NoteReasons(controller, record);
    CheckMeant(record);
    CheckFence(controller, record);
  };
  robot_.on_power = [this] { power_due_.reset(); };
  robot_.on_battery = [this](int percent, bool charging) { OnBattery(percent, charging); };
  robot_.on_begin = [this](const ControllerProcess& controller, bool restarted) {
    if (!restarted) accepted_tear_down_.reset();
    NoteWord(controller, restarted);
  };
  robot_.on_release_answered = [this](const ControllerProcess& controller,
                                      const Result<>& released) {
    CheckReleased(controller, released);
  };
}

void Checker::ReportViolation(Invariant invariant, const std::string& what) {
  if (violation_) return;
  violation_ = {invariant, robot_.age(), what};
}

void Checker::OnWrite(const ControllerProcess& controller, const std::string& topic,
                      const msg::Bytes& bytes) {
  if (topic.starts_with("rr/")) return OnReplyWritten(controller, topic.substr(3));
  if (!topic.ends_with("musher/emergency_stop")) return;
  if (const auto stop = msg::Decode<msg::EmergencyStop>(bytes)) OnStopPublished(controller, *stop);
}

void Checker::OnReport(const std::string& name, std::size_t host, const ActuatorReport& report) {
  ++checks_;
  ActuatorReport& before = reports_[{name, report.host}];
  if (before.incarnation != report.incarnation) before = ActuatorReport{};
  if (report.epoch < before.epoch || report.number < before.number) {
    ReportViolation(Invariant::kNoStaleCommand, name + " goes back to epoch " +
                                                    ToString(report.epoch) + ", command " +
                                                    ToString(report.number));
  }
  const bool begun = report.busy() && (!before.busy() || before.target != report.target ||
                                       before.busy_number != report.busy_number);
  if (begun) OnBegun(name, before, report);
  CheckFollows(name, host, report);
  if (const ActuatorCore* core = robot_.processes().CoreOf(name, host)) {
    CheckControllerOf(name, core->controller);
  }
  CheckStopped(name, host, before, report);
  CheckWaiting(name, host, report);
  before = report;
}

// A callback has begun.
void Checker::OnBegun(const std::string& name, const ActuatorReport& before,
                      const ActuatorReport& report) {
  const bool rises = Rises(config_, report.state, report.target);
  const std::string what = name + " begins " + report.target + " in " + report.state;
  if (rises && report.emergency_stop != 0 && before.emergency_stop == report.emergency_stop) {
    return ReportViolation(Invariant::kEmergencyStopHolds,
                           what + " although it has latched an emergency stop");
  }
  if (report.target == kSetUp) return;
  if (report.busy_number == 0) {
    self_switched_.insert(name);
    if (rises) ReportViolation(Invariant::kNoUnrequestedActivation, what + " without a command");
    return;
  }
  self_switched_.erase(name);
  const auto sent = sent_commands_.find({report.epoch, *config_.IndexOf(name), report.busy_number});
  if (sent == sent_commands_.end()) {
    return ReportViolation(Invariant::kNoStaleCommand,
                           what + " although no controller has sent that command");
  }
  const Duration age = robot_.network().now() - sent->second.sent;
  if (age > sent->second.budget + kClockSlack) {
    ReportViolation(Invariant::kNoStaleCommand,
                    what + ", by a command that is " + std::to_string(ToMilliseconds(age)) +
                        " ms old and had " + std::to_string(ToMilliseconds(sent->second.budget)) +
                        " ms");
  }
  if (rises && !sent->second.may_rise) {
    ReportViolation(Invariant::kNoUnrequestedActivation, what + ", which was not requested");
  }
  if (rises && !sent->second.has_reason) {
    ReportViolation(Invariant::kRisesAreRecorded,
                    what + ", for which its controller has recorded no reason");
  }
}

// A controller knows the exit code of its own children only.
void Checker::OnWrongConfig(const std::string& name) {
  const ControllerProcess* leader = robot_.leader();
  if (leader == nullptr) return;
  const ActuatorIndex i = *config_.IndexOf(name);
  const RestartConfig& restart = config_.actuators[i].restart;
  const ActuatorRecord& record = leader->shell().machine().actuators[i];
  const bool its_child = record.process.pid != 0 &&
                         record.process.pid == robot_.processes().PidOf(name, leader->host()) &&
                         record.process.launch != Launch::kFoundRunning;
  const bool counts = restart.policy != RestartPolicy::kNo && restart.Prevents(kUsageExitCode);
  if (its_child && counts && !record.restart.requested) config_errors_[name] = leader->serial();
}

void Checker::OnStart(const ControllerProcess& controller, const std::string& name) {
  ++checks_;
  CheckRunsNowhereElse(controller, name);
  const auto ended = config_errors_.find(name);
  if (ended != config_errors_.end() && ended->second == controller.serial()) {
    ReportViolation(Invariant::kNoRestartOnConfigError,
                    name + ", which exited with code 2, is restarted without a request");
  }
  config_errors_.erase(name);
  const ActuatorIndex i = *config_.IndexOf(name);
  const RestartConfig& restart = config_.actuators[i].restart;
  const bool ends_at_once = robot_.processes().IsMisconfigured(name);
  const bool counts = restart.policy != RestartPolicy::kNo && restart.Prevents(kUsageExitCode);
  if (ends_at_once && counts) config_errors_[name] = controller.serial();
}

void Checker::AfterEvent() {
  CheckPowerOff();
  if (!idle_and_stopped_.empty()) CheckPower();
  CheckClients();
  if (!dirty_) return;
  dirty_ = false;
  for (std::size_t which = 0; which < 2; ++which) {
    const ControllerProcess* controller = robot_.controller(which);
    if (controller == nullptr || !controller->leads()) continue;
    if (controller->frozen) {
      seen_[controller->serial()].over_since.reset();
      continue;
    }
    ++checks_;
    CheckController(*controller);
  }
  just_replied_.clear();
}

void Checker::CheckController(const ControllerProcess& controller) {
  const Machine& machine = controller.shell().machine();
  Seen& seen = seen_[controller.serial()];
  if (const std::string broken = BrokenInvariant(config_, machine); !broken.empty()) {
    ReportViolation(Invariant::kMachineIsConsistent, broken);
  }
  CheckDeadline(controller, seen);
  NoteReceived(controller, seen);
  const Epoch epoch = std::exchange(seen.epoch, machine.epoch);
  if (epoch == 0) seen.began_with = machine.epoch;
  if (epoch != 0 && epoch != machine.epoch) {
    CheckRaised(controller, seen, epoch);
    CarryCommandsOver(controller.serial(), epoch, machine.epoch);
  }
  seen.starts = machine.phase == Phase::kStarting;
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const bool present = machine.actuators[i].presence == Presence::kPresent;
    if (present) lost_at_[i] = robot_.age();
    if (!present && !machine.actuators[i].command) NoteGivenUp(machine.epoch, i);
  }
  CheckReason(controller, seen.state);
  CheckChange(machine, seen);
  CheckCeiling(machine, false);
  CheckQuiet(machine, seen);
  CheckStaysDown(controller);
}

void Checker::OnSend(const Machine& machine, const action::SendSwitch& send) {
  const SwitchCommand& command = send.command;
  const std::uint64_t controller = SerialOf(machine);
  // The rollback of a single actuator leads back up.
  const bool back = machine.current && machine.current->rollback.under_way && machine.current->only;
  sent_commands_[{command.epoch, send.actuator, command.number}] = {
      robot_.network().now(), command.budget, MayRise(machine, command.target), controller,
      back || HasReason(controller, machine.state, command.target)};
}

std::uint64_t Checker::SerialOf(const Machine& machine) const {
  for (std::size_t which = 0; which < 2; ++which) {
    const ControllerProcess* controller = robot_.controller(which);
    if (controller != nullptr && &controller->shell().machine() == &machine) {
      return controller->serial();
    }
  }
  return 0;
}

// A controller has raised its epoch: what it has sent and what waits at the actuators keeps
// waiting, under the new one.
void Checker::CarryCommandsOver(std::uint64_t controller, Epoch from, Epoch to) {
  const std::vector<std::pair<CommandKey, SentCommand>> sent(
      sent_commands_.lower_bound({from, ActuatorIndex(), CommandNumber()}),
      sent_commands_.lower_bound({from + 1, ActuatorIndex(), CommandNumber()}));
  for (const auto& [key, command] : sent) {
    if (command.controller != controller) continue;
    sent_commands_.try_emplace({to, std::get<1>(key), std::get<2>(key)}, command);
  }
}

// Of the events at one instant another one may come first, such as a step of another controller.
void Checker::CheckDeadline(const ControllerProcess& controller, Seen& seen) {
  constexpr int kOthers = 100;
  const Time now = robot_.network().now();
  const auto deadline = NextDeadline(config_, controller.shell().machine());
  if (!deadline || *deadline > controller.Now()) return seen.over_since.reset();
  if (!seen.over_since) seen.over_since = {now, 0};
  if (now > seen.over_since->first || ++seen.over_since->second > kOthers) {
    ReportViolation(Invariant::kNoPastDeadline,
                    "a deadline of the controller has passed and is still its next");
  }
}

// An actuator may be commanded up by a requested switch, or to the machine's state.
bool Checker::MayRise(const Machine& machine, const State& target) const {
  const auto& s = machine.current;
  const bool may = s && (IsRequested(*s) || s->purpose == Purpose::kPolicy);  // see CheckRaise
  if (may && s->target == target) return true;
  const auto place = config_.RankOf(machine.state);
  const auto rank = config_.RankOf(target);
  if (rank && place && *rank <= *place) return true;
  // A rollback of a single actuator may lead back up.
  return machine.current && machine.current->rollback.under_way && machine.current->only;
}

void Checker::CheckChange(const Machine& machine, Seen& seen) {
  const auto before = config_.RankOf(seen.state);
  const auto rank = config_.RankOf(machine.state);
  if (before && rank && *rank > *before) {
    // Several switches may have ended since.
    const bool requested =
        seen.requested_state == machine.state || ByPolicy(machine.state) ||
        std::any_of(just_replied_.begin(), just_replied_.end(), [&](const State& state) {
          const auto other = config_.RankOf(state);
          return other && *other >= *rank;
        });
    const std::string what = "the machine went from " + seen.state + " to " + machine.state;
    if (!requested)
      ReportViolation(Invariant::kNoUnrequestedActivation, what + ", which was not requested");
    if (seen.stopped && machine.emergency.stop) {
      ReportViolation(Invariant::kEmergencyStopHolds, what + " during an emergency stop");
    }
  }
  if (!machine.recorded_state.empty() && machine.recorded_state != machine.state) {
    ReportViolation(
        Invariant::kStatesRecorded,
        "the machine is in " + machine.state + ", the journal records " + machine.recorded_state);
  }
  if (seen.state != machine.state) CheckPolicyChange(machine, seen);
  seen.state = machine.state;
  seen.stopped = machine.emergency.stop.has_value();
  const bool requested = (seen.requested && machine.state == seen.requested_state) ||
                         just_replied_.contains(machine.state);
  if (requested && !machine.current) requested_state_at_ = robot_.age();
  seen.requested_state.reset();
  if (machine.current && IsRequested(*machine.current))
    seen.requested_state = machine.current->target;
  seen.requested = machine.current && machine.current->purpose == Purpose::kRequested;
  if (machine.waiting) {  // the switch may begin and end in one step
    seen.requested_state = machine.waiting->target;
    seen.requested = true;
  }
}

std::uint64_t Checker::OnRequest(const ControllerProcess& controller, const State& target) {
  urgent_requested_ |= target == kError || target == kTearDown;
  open_requests_[next_request_] = {target, controller.serial()};
  return next_request_++;
}

void Checker::OnControllerKilled(const ControllerProcess& controller) {
  OnControllersBlocked(false);
  std::erase_if(open_requests_, [&](const auto& request) {
    return request.second.controller == controller.serial();
  });
}

}  // namespace musher::simulation
