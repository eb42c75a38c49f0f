#include "musher/simulation/checker.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/lifecycle/coordinator/coordinator.hpp"
#include "musher/lifecycle/machine/machine_invariants.hpp"
#include "musher/lifecycle/policy/policy.hpp"

namespace musher::simulation {
namespace {

// How much older than its budget a command may be when it begins: the clocks of two hosts are
// compared by the report with the shortest transit time.
constexpr Duration kClockSlack = Milliseconds(100);

bool IsRequested(const Switch& s) {
  return s.purpose == Purpose::kRequested || s.purpose == Purpose::kStartUpActivate ||
         s.purpose == Purpose::kStartUpCheck;
}

// After this long with a working link a controller has received a process's status.
constexpr Duration kReceivedAfter = std::chrono::seconds(2);
// A controller may react so long to a fault of a process, or of its link, that is over.
constexpr Duration kReactsFor = std::chrono::seconds(30);

// A client's process notices within this that a controller has ended: the missed heartbeats, and a
// grace for a reply under way.
constexpr Duration kNotifiedWithin = std::chrono::seconds(4);
constexpr Duration kClientPeriod = Milliseconds(200);  // of the checks
// A request in a stable state has a reply, or the service is not available.
constexpr Duration kRepliedAtRest = std::chrono::seconds(12);

// For the event loop and the network.
constexpr Duration kPowerSlack = std::chrono::seconds(1);

// What an actuator's own stop names where no permit to move has arrived.
constexpr std::string_view kPermitKey = "[safety] permit_ms";
// The first permit of a console counts as fresh, however long it took: 400 ms at most, and 80 ms on
// links with faults.
constexpr Duration kPermitSlack = Milliseconds(500);
constexpr Duration kPermitPeriod = Milliseconds(20);  // of the checks

// A step of /clock that is longer is a jump.
constexpr Duration kLongestStep = std::chrono::seconds(10);
// A controller has received what was published so long before, on links without faults.
constexpr Duration kClockLag = Milliseconds(250);

// The highest rank that the battery permits, without hysteresis.
std::optional<Rank> MostAt(const BatteryPolicy& policy, int percent, bool charging) {
  if (percent <= policy.low_power_at && !charging) return BuiltInRank(kLowPower);
  if (percent <= policy.protected_at) return BuiltInRank(kProtected);
  return std::nullopt;
}

State TargetOf(const action::Record& record) {
  return State(ArgumentOf(record.arguments, "target"));
}

std::optional<int> PercentOf(const action::Record& record) {
  const Argument* percent = FindArgument(record.arguments, "percent");
  if (percent == nullptr) return std::nullopt;
  return static_cast<int>(std::get<std::int64_t>(percent->value));
}

}  // namespace

Checker::Checker(SimRobot& robot)
    : robot_(robot), config_(robot.config()), lost_at_(config_.actuators.size()) {
  robot_.on_input = [this] { dirty_ = true; };
  robot_.on_send = [this](const Machine& machine, const action::SendSwitch& send) {
    OnSend(machine, send);
  };
  robot_.on_start = [this](const SimulatedController& controller, const std::string& name) {
    OnStart(controller, name);
  };
  robot_.processes().on_report = [this](const std::string& name, std::size_t host,
                                        const ActuatorReport& report) {
    OnReport(name, host, report);
  };
  robot_.on_write = [this](const SimulatedController& controller, const std::string& topic,
                           const msg::Bytes& bytes) { OnWrite(controller, topic, bytes); };
  robot_.on_signal = [this](const SimulatedController& controller, std::int32_t pid) {
    CheckSignal(controller, pid);
    CheckKill(controller, pid);
  };
  robot_.on_record_of = [this](const SimulatedController& controller,
                               const action::Record& record) {
    recording_host_ = controller.host();
    NoteReasons(controller, record);
    NoteRequest(controller, record);
    CheckPolicyTime(controller, record);
    CheckMeant(record);
    CheckFence(controller, record);
  };
  robot_.on_power = [this] { power_due_.reset(); };
  robot_.on_battery = [this](int percent, bool charging) { OnBattery(percent, charging); };
  robot_.on_permit = [this](Time stamp) { permits_[stamp] = robot_.network().now(); };
  robot_.on_clock = [this](Time time) { OnClock(time); };
  robot_.on_motion = [this](std::int32_t motion) { OnMotion(motion); };
  robot_.on_begin = [this](const SimulatedController& controller, bool restarted) {
    if (!restarted) {
      accepted_tear_down_.reset();
      if (TakesNothingOver(controller)) begun_by_a_person_[controller.serial()] = ++order_;
    }
    if (robot_.FindsUnreadFolder(controller)) unanswered_.insert(controller.serial());
    NoteWord(controller, restarted);
  };
  robot_.on_release_answered = [this](const SimulatedController& controller,
                                      const Result<>& released) {
    CheckReleased(controller, released);
  };
}

void Checker::ReportViolation(Invariant invariant, const std::string& what) {
  if (violation_) return;
  violation_ = {invariant, robot_.age(), what};
}

void Checker::OnWrite(const SimulatedController& controller, const std::string& topic,
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
  if (begun) OnBegun(name, host, before, report);
  NoteOverrun(name, host, begun, report);
  CheckFollows(name, host, report);
  if (const ActuatorCore* core = robot_.processes().CoreOf(name, host)) {
    CheckControllerOf(name, core->controller);
    NotePermitStops(*core);
  }
  CheckStaysStopped(name, before, report);
  CheckStopped(name, host, before, report);
  CheckWaiting(name, host, report);
  before = report;
}

// A callback has begun.
void Checker::OnBegun(const std::string& name, std::size_t host, const ActuatorReport& before,
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
  // A controller lowers an actuator that claims to be more active than it is.
  const bool lowered = false_reporters_.contains(name) && !Rises(config_, kDeActive, report.target);
  if (rises && !sent->second.may_rise && !lowered) {
    ReportViolation(Invariant::kNoUnrequestedActivation, what + ", which was not requested");
  }
  if (rises && !sent->second.has_reason) {
    ReportViolation(Invariant::kRisesAreRecorded,
                    what + ", for which its controller has recorded no reason");
  }
  CheckAfterRelease(name, host, before, report, sent->second);
}

// A controller knows the exit code of its own children only.
void Checker::OnWrongConfig(const std::string& name) {
  const SimulatedController* leader = robot_.leader();
  if (leader == nullptr) return;
  const ActuatorIndex i = *config_.IndexOf(name);
  const RestartConfig& restart = config_.actuators[i].restart;
  const KnownActuator& known = leader->shell().machine().actuators[i];
  const bool its_child = known.process.pid != 0 &&
                         known.process.pid == robot_.processes().PidOf(name, leader->host()) &&
                         known.process.launch != Launch::kFoundRunning;
  const bool counts = restart.policy != RestartPolicy::kNo && restart.Prevents(kUsageExitCode);
  if (its_child && counts && !known.restart.requested) config_errors_[name] = leader->serial();
}

void Checker::OnStart(const SimulatedController& controller, const std::string& name) {
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
  CheckPermits();
  CheckClients();
  if (!dirty_) return;
  dirty_ = false;
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* controller = robot_.controller(which);
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

void Checker::CheckController(const SimulatedController& controller) {
  const Machine& machine = controller.shell().machine();
  Seen& seen = seen_[controller.serial()];
  if (const std::string broken = BrokenInvariant(config_, machine); !broken.empty()) {
    ReportViolation(Invariant::kMachineIsConsistent, broken);
  }
  CheckDeadline(controller, seen);
  NoteReceived(controller, seen);
  if (seen.lost_at.empty()) {
    seen.lost_at = lost_at_;
    seen.requested_state_at = requested_state_at_;
  }
  const Epoch epoch = std::exchange(seen.epoch, machine.epoch);
  if (epoch == 0) seen.began_with = machine.epoch;
  if (epoch != 0 && epoch != machine.epoch) {
    CheckRaised(controller, seen, epoch);
    CarryCommandsOver(controller.serial(), epoch, machine.epoch);
  }
  seen.starts = machine.phase == Phase::kStarting;
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const bool present = machine.actuators[i].presence == Presence::kPresent;
    if (present) lost_at_[i] = seen.lost_at[i] = robot_.age();
    if (!present && !machine.actuators[i].command) NoteGivenUp(machine.epoch, i);
  }
  CheckReason(controller, seen.state);
  CheckChange(machine, seen);
  CheckCeiling(controller, false);
  CheckQuiet(machine, seen);
  NotePolicyTimes(controller, seen);
  CheckStaysDown(controller);
}

void Checker::OnSend(const Machine& machine, const action::SendSwitch& send) {
  const SwitchCommand& command = send.command;
  const std::uint64_t controller = SerialOf(machine);
  // The rollback of a single actuator leads back up.
  const bool back = machine.current && machine.current->rollback.under_way && machine.current->only;
  sent_commands_[{command.epoch, send.actuator, command.number}] = {
      robot_.network().now(),
      command.budget,
      MayRise(machine, command.target),
      controller,
      back || HasReason(controller, machine.state, command.target),
      IsRequestedSinceStop(controller, send.actuator, command.target),
      ++order_};
}

std::uint64_t Checker::SerialOf(const Machine& machine) const {
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* controller = robot_.controller(which);
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

// Of the events at one instant others may come first, such as a step of another controller, or the
// stops that a panel engages by the hundred.
void Checker::CheckDeadline(const SimulatedController& controller, Seen& seen) {
  constexpr int kOthers = 10'000;
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
  if (requested && !machine.current) {
    requested_state_at_ = seen.requested_state_at = robot_.age();
  }
  seen.requested_state.reset();
  if (machine.current && IsRequested(*machine.current))
    seen.requested_state = machine.current->target;
  seen.requested = machine.current && machine.current->purpose == Purpose::kRequested;
  if (machine.waiting) {  // the switch may begin and end in one step
    seen.requested_state = machine.waiting->target;
    seen.requested = true;
  }
}

std::uint64_t Checker::OnRequest(const SimulatedController& controller, const State& target) {
  urgent_requested_ |= target == kError || target == kTearDown;
  open_requests_[next_request_] = {target, controller.serial()};
  return next_request_++;
}

void Checker::OnControllerKilled(const SimulatedController& controller) {
  OnControllersBlocked(false);
  std::erase_if(open_requests_, [&](const auto& request) {
    return request.second.controller == controller.serial();
  });
}

// --- hosts and the processes on them ---

// A controller starts a process. If one of the same actuator runs on another host, the controller
// knows of it unless the link was cut shortly before.
void Checker::CheckRunsNowhereElse(const SimulatedController& controller, const std::string& name) {
  CheckProgramRunsOnce(controller, name);
  const SimulatedProcesses& processes = robot_.processes();
  const Time now = robot_.network().now();
  for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
    const ActuatorReport* report = processes.ReportOf(name, host);
    if (host == controller.host() || report == nullptr) continue;
    const std::string& endpoint = processes.EndpointOf(name, host);
    const auto in_reach = [&](const std::string& from, const std::string& to) {
      const auto blocked = robot_.hosts().BlockedUntil(from, to);
      return !blocked || *blocked <= now - kReceivedAfter;
    };
    const bool known =
        in_reach(endpoint, controller.endpoint()) && in_reach(controller.endpoint(), endpoint) &&
        processes.StartOf(name, host) <= now - kReceivedAfter && !processes.IsFrozen(name, host);
    if (!known) {
      const ActuatorIndex process = robot_.layout().ProcessOf(*config_.IndexOf(name));
      for (const ActuatorIndex i : config_.actuators.Indices()) {
        if (robot_.layout().ProcessOf(i) == process) duplicated_.insert(config_.actuators[i].name);
      }
      continue;
    }
    if (report->state == kTearDown) continue;
    ReportViolation(Invariant::kNoDuplicateActuator,
                    "the controller on host " + robot_.hosts().name(controller.host()) +
                        " starts " + name + ", which runs on host " + robot_.hosts().name(host));
  }
}

// A controller signals a process: it must be its child, or hold the name of the actuator that the
// controller takes it for.
void Checker::CheckSignal(const SimulatedController& controller, std::int32_t pid) {
  const Machine& machine = controller.shell().machine();
  bool unproven = true;
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const KnownActuator& known = machine.actuators[i];
    const bool terminated = known.process.termination && known.process.termination->pid == pid;
    const bool meant = known.process.pid == pid || terminated || known.report.pid == pid;
    const bool holds =
        robot_.processes().PidOf(config_.actuators[i].name, controller.host()) == pid;
    unproven &= !(meant && holds);
  }
  if (!unproven || !robot_.processes().Exists(controller.host(), pid)) return;
  ReportViolation(Invariant::kOnlyOwnProcessesSignalled,
                  "the controller signals process " + std::to_string(pid) +
                      ", which is not the process of that actuator");
}

void Checker::OnLinkFaults(bool active) {
  if (active) {
    link_faults_until_ = Time::max();
  } else if (link_faults_until_ == Time::max()) {
    link_faults_until_ = robot_.network().now();
  }
}

// Runs after each step of an actuator. Until the end of a callback its heartbeats report that it
// has run for longer than without a checkpoint.
void Checker::NoteOverrun(const std::string& name, std::size_t host, bool begun,
                          const ActuatorReport& report) {
  const ActuatorConfig& actuator = config_.actuators[*config_.IndexOf(name)];
  const Time now = robot_.network().now();
  RunningCallback& callback = callbacks_[{name, host}];
  if (begun) {
    const auto longer = actuator.checkpoint_in.find(report.target);
    const auto limit =
        longer != actuator.checkpoint_in.end() ? longer->second : actuator.checkpoint;
    callback.late_at.reset();
    if (limit) callback.late_at = now + *limit;
  } else if (!report.busy()) {
    if (callback.late_at && *callback.late_at < now) callback.overran_until = now;
    callback.late_at.reset();
  }
}

// Whether nothing is, or was a short while ago, wrong with the process and its link to a controller
// of its host.
bool Checker::IsWell(const SimulatedController& controller, const std::string& name) const {
  const Time now = robot_.network().now();
  const auto recent = [&](const std::optional<Time>& until) {
    return until && (*until == Time::max() || now - *until < kReactsFor);
  };
  const SimulatedProcesses& processes = robot_.processes();
  const std::size_t host = controller.host();
  const std::string& endpoint = processes.EndpointOf(name, host);
  const ActuatorReport* report = processes.ReportOf(name, host);
  if (report == nullptr || report->busy() || report->state == kTearDown) return false;
  const auto callback = callbacks_.find({name, host});
  const bool overran = callback != callbacks_.end() && callback->second.overran_until &&
                       now - *callback->second.overran_until < kReceivedAfter;
  return !overran && !recent(processes.FrozenUntil(name, host)) && !recent(controller.thawed) &&
         !recent(link_faults_until_) &&
         !recent(robot_.hosts().BlockedUntil(endpoint, controller.endpoint())) &&
         !recent(robot_.hosts().BlockedUntil(controller.endpoint(), endpoint));
}

// A controller signals a process of its host. Unless it tears the machine down, or was requested to
// restart an actuator of that process, the process must have a fault of its own.
void Checker::CheckKill(const SimulatedController& controller, std::int32_t pid) {
  const Machine& machine = controller.shell().machine();
  if (machine.phase == Phase::kStopping || machine.phase == Phase::kStopped) return;
  std::string killed;
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const std::string& name = config_.actuators[i].name;
    if (robot_.processes().PidOf(name, controller.host()) != pid) continue;
    const KnownActuator& known = machine.actuators[i];
    if (known.restart.requested || !IsWell(controller, name)) return;
    killed = name;
  }
  if (killed.empty()) return;
  ReportViolation(Invariant::kNoKillForTheNetwork,
                  "the controller ends the process of " + killed + ", which is well");
}

// A controller starts a program of another protocol. The program holds no name that would prevent a
// second process; the controller has to know that the first one runs.
void Checker::CheckProgramRunsOnce(const SimulatedController& controller, const std::string& name) {
  const SimulatedProcesses& processes = robot_.processes();
  if (!processes.IsProgram(name) || !processes.IsAlive(name, controller.host())) return;
  ReportViolation(Invariant::kNoDuplicateActuator,
                  "the controller starts " + name + ", which already runs as process " +
                      std::to_string(processes.PidOf(name, controller.host())));
}

void Checker::CheckRunsOnce(const std::string& name) {
  if (robot_.processes().CountOf(name) < 2 || duplicated_.contains(name)) return;
  ReportViolation(Invariant::kNoDuplicateActuator, name + " runs on several hosts");
}

// --- authority: the newest word of a person counts, and nothing rises without one ---

void Checker::NoteWord(const SimulatedController& controller, bool restarted) {
  std::uint64_t& last = last_word_on_[controller.host()];
  if (!restarted || last == 0) last = ++words_;
  Word word{last, controller.serial(), {}, {}};
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* other = robot_.controller(which);
    if (other == nullptr || other == &controller || !other->leads()) continue;
    const Machine& machine = other->shell().machine();
    if (machine.phase == Phase::kStarting) word.together.insert(other->serial());
    word.others[other->serial()] = machine.epoch;
  }
  word_of_[controller.serial()] = std::move(word);
}

void Checker::CheckRaised(const SimulatedController& controller, Seen& seen, Epoch before) {
  const Epoch epoch = controller.shell().machine().epoch;
  if (++seen.raised == 1 && seen.starts && epoch > before) return;
  ReportViolation(Invariant::kEpochRaisedOnce,
                  "the controller on host " + robot_.hosts().name(controller.host()) +
                      " goes from epoch " + ToString(before) + " to " + ToString(epoch) +
                      (seen.starts ? " in its start" : " while it runs") + ", raise " +
                      std::to_string(seen.raised));
}

// An actuator follows a controller. It must not be one that a person has replaced, while the newer
// one leads; unless the older one had a higher epoch already, of which the person did not know.
void Checker::CheckFollows(const std::string& name, std::size_t host,
                           const ActuatorReport& report) {
  const ActuatorCore* core = robot_.processes().CoreOf(name, host);
  if (core == nullptr || core->controller == 0) return;
  Followed& followed = followed_[{name, host}];
  if (followed.incarnation != report.incarnation) followed = {report.incarnation, {}};
  const SimulatedController* controller = nullptr;
  const SimulatedController* newer = nullptr;
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* one = robot_.controller(which);
    if (one == nullptr) continue;
    if (Sender(one->participant().value()) == core->controller) controller = one;
    if (one->serial() == followed.word.controller && one->leads()) newer = one;
  }
  if (controller == nullptr || !word_of_.contains(controller->serial())) return;
  const Word& word = word_of_.at(controller->serial());
  if (word.number >= followed.word.number) {
    followed.word = word;
    return;
  }
  if (newer == nullptr || followed.word.together.contains(controller->serial())) return;
  const Epoch epoch = controller->shell().machine().epoch;
  const auto known = followed.word.others.find(controller->serial());
  const bool raised = known == followed.word.others.end() || known->second != epoch;
  const Epoch newest = newer->shell().machine().epoch;
  if (!raised && epoch >= newest) return;
  // Restarted by its supervisor meanwhile: its disk has the epoch, which that person had not seen.
  if (seen_[controller->serial()].began_with == epoch && epoch > newest) return;
  ReportViolation(Invariant::kTakeoverLasts, name + " returns to the controller on host " +
                                                 robot_.hosts().name(controller->host()) +
                                                 ", epoch " + ToString(report.epoch) +
                                                 ", which a person has replaced");
}

// A controller records what a person has requested of it, and what its policy has decided.
void Checker::NoteReasons(const SimulatedController& controller, const action::Record& record) {
  switch (record.event) {
    case EventName::kSwitchRequested:
    case EventName::kPolicyRequested:
    case EventName::kBatterySwitchUp:
    case EventName::kBatterySwitchDown:
    case EventName::kLyingStillSwitch:
      break;
    default:
      return;
  }
  const State target(ArgumentOf(record.arguments, "target"));
  // A wake-up, for one, leads to Active or as far as the battery permits.
  reasons_[controller.serial()].insert(target.empty() ? State(kActive) : target);
}

// Whether a machine in `from` may bring itself, or an actuator, to `to`. Where a start has not led
// to a state yet, the start is the reason. An actuator joins in the machine's state.
bool Checker::HasReason(std::uint64_t controller, const State& from, const State& to) const {
  const auto place = config_.RankOf(from);
  const auto rank = config_.RankOf(to);
  if (!place || !rank || *rank <= *place) return true;
  const auto reasons = reasons_.find(controller);
  return reasons != reasons_.end() &&
         std::any_of(reasons->second.begin(), reasons->second.end(), [&](const State& reason) {
           return reason == to || config_.RankOf(reason).value_or(0) >= *rank;
         });
}

// The state of a machine may have changed since `before`.
void Checker::CheckReason(const SimulatedController& controller, const State& before) {
  const Machine& machine = controller.shell().machine();
  if (!HasReason(controller.serial(), before, machine.state)) {
    ReportViolation(Invariant::kRisesAreRecorded,
                    "the machine went from " + before + " to " + machine.state +
                        ", for which the controller has recorded no reason");
  }
  if (!machine.current && !machine.waiting) reasons_[controller.serial()].clear();
}

// --- two machines in one network: nothing that is meant for one changes the other ---

// The engaged stops of panels have no identity, and are latched: they reach a machine that comes
// later, too.
void Checker::TakeStopsOf(const Checker& other) {
  constexpr std::size_t kPanels = 2;
  for (const auto& [panel, id] : other.last_of_panel_) {
    if (panel < kPanels) OnStopEngaged(panel, id);
  }
}

// A controller acts on a client's request. Clients name themselves after the machine they mean.
void Checker::CheckMeant(const action::Record& record) {
  if (other_ == nullptr) return;
  const std::string theirs = Client::Name(other_->identity().id);
  if (record.message.find(theirs) == std::string::npos) return;
  ReportViolation(
      Invariant::kReachesMeantMachine,
      "machine " + robot_.identity().id + " acts on a request of another: " + record.message);
}

// An actuator obeys the controllers of its own machine.
void Checker::CheckControllerOf(const std::string& name, Sender controller) {
  if (other_ == nullptr || controller == 0) return;
  if (!other_->IsController(transport::ParticipantId(controller.value()))) return;
  ReportViolation(Invariant::kReachesMeantMachine,
                  name + " obeys a controller of machine " + other_->identity().id);
}

// A controller is fenced. A controller of its own machine must have begun beside it, or has
// requested that as a process of the same host.
void Checker::CheckFence(const SimulatedController& controller, const action::Record& record) {
  if (record.event != EventName::kControllerFenced || other_ == nullptr) return;
  const bool requested = record.message.find("of this host") != std::string::npos;
  const bool has_rival = word_of_.size() > word_of_.count(controller.serial());
  if (requested || has_rival) return;
  ReportViolation(
      Invariant::kOtherMachineNeverFences,
      "the only controller of machine " + robot_.identity().id + " is fenced: " + record.message);
}

// --- emergency stops, and an accepted TearDown ---

void Checker::OnStopEngaged(std::size_t panel, StopId id) {
  engaged_[id] = panel;
  last_of_panel_[panel] = id;
  engaged_at_[id] = robot_.network().now();
}

// A controller publishes a stop. Only a controller releases one.
void Checker::OnStopPublished(const SimulatedController& controller,
                              const msg::EmergencyStop& stop) {
  if (stop.engaged) {
    accepted_stops_[StopId(stop.id)].insert(controller.host());
    stopped_on_[controller.host()] = seen_[controller.serial()].stop_order = ++order_;
    release_order_.erase(StopId(stop.id));
  } else {
    released_[StopId(stop.id)].insert(controller.host());
    release_order_.try_emplace(StopId(stop.id), ++order_);
    released_at_ = robot_.network().now();
  }
}

// A release is stored on the disk of the host whose controller received it. If a controller of
// another host leads afterwards, a panel that is still available engages the stop again.
bool Checker::ReleasedElsewhere() const {
  const SimulatedController* leader = robot_.leader();
  return leader != nullptr &&
         std::any_of(released_.begin(), released_.end(), [leader](const auto& release) {
           return !release.second.contains(leader->host());
         });
}

// Whether a stop is still engaged. A panel keeps its last stop only. An earlier stop is lost if no
// controller had received it, if the disk that had it is lost, or if that disk is on another host
// than the controller that leads. A program publishes its stop for some time only: whether the stop
// is engaged later depends on which controllers and actuators have received it.
Checker::Open Checker::StopIsOpen() const {
  const SimulatedController* leader = robot_.leader();
  Open open = Open::kNo;
  for (const auto& [id, panel] : engaged_) {
    if (released_.contains(id)) continue;
    const auto accepted = accepted_stops_.find(id);
    const bool kept = accepted != accepted_stops_.end() && leader != nullptr &&
                      accepted->second.contains(leader->host()) && !state_lost_;
    const bool published = last_of_panel_.at(panel) == id && !withdrawn_.contains(id);
    if (kept || published) return Open::kYes;
    if (withdrawn_.contains(id)) open = Open::kMaybe;
  }
  return open;
}

void Checker::CheckStopsAtRest(const Machine& machine) {
  const bool known = machine.emergency.stop.has_value();
  const Open is_open = StopIsOpen();
  const bool open = is_open == Open::kMaybe ? known : is_open == Open::kYes;
  const auto excused = [&](bool latched) {
    return latched && !open && (state_lost_ || ReleasedElsewhere());
  };
  const std::string what = open ? " although one is engaged" : " although all stops are released";
  if (known != open && !excused(known)) {
    return ReportViolation(
        Invariant::kEmergencyStopLatched,
        std::string("the controller has ") + (known ? "an" : "no") + " emergency stop" + what);
  }
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const ActuatorReport* report = robot_.ReportOf(i, machine.actuators[i].report);
    if (report == nullptr || machine.actuators[i].presence != Presence::kPresent) continue;
    const bool latched = report->emergency_stop != 0;
    if (latched == open || excused(latched)) continue;
    ReportViolation(Invariant::kEmergencyStopLatched, config_.actuators[i].name + " has latched " +
                                                          (latched ? "an" : "no") +
                                                          " emergency stop" + what);
  }
}

// Nothing of it is on: by its hardware, or by its report where that is not known.
bool Checker::IsStopped(const std::string& name, std::size_t host,
                        const ActuatorReport& report) const {
  if (robot_.processes().HasPower(name, host)) return !robot_.processes().IsPowered(name, host);
  const bool off = !Rises(config_, kDeActive, report.state) && !report.busy();
  return report.emergency_stop != 0 || off;
}

// Every actuator of the machine is stopped, unless the stop was released meanwhile. The program
// takes the word of the controller that it reaches. That controller cannot know of a process beyond
// a cut link if no controller of its host has ever received the process.
void Checker::OnStopConfirmed(StopId id) {
  ++checks_;
  if (released_at_ && *released_at_ >= engaged_at_[id]) return;
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const std::string& name = config_.actuators[i].name;
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const ActuatorReport* report = robot_.processes().ReportOf(name, host);
      if (report == nullptr || IsStopped(name, host, *report)) continue;
      const auto knows = [&](const SimulatedController* controller) {
        return controller == nullptr || !controller->leads() ||
               IsKnown(*controller, i, host, *report);
      };
      if (duplicated_.contains(name) || !knows(robot_.controller(0))) continue;
      if (robot_.leader() == nullptr || !knows(robot_.controller(1))) continue;
      ReportViolation(Invariant::kStopIsConfirmed, "the machine is reported as stopped, and " +
                                                       name + " is on in " + report->state +
                                                       " on host " + robot_.hosts().name(host));
    }
  }
}

// Runs after each step of an actuator.
void Checker::CheckStopped(const std::string& name, std::size_t host, const ActuatorReport& before,
                           const ActuatorReport& report) {
  const bool reports_on = !report.busy() && !report.held_by_stop && report.incarnation != 0 &&
                          Rises(config_, kUninitialized, report.state);
  const SimulatedProcesses& processes = robot_.processes();
  if (reports_on && processes.HasPower(name, host) && !processes.IsPowered(name, host)) {
    ReportViolation(
        Invariant::kEmergencyStopReported,
        name + " reports " + report.state + " with its power off, and not that a stop holds it");
  }
  if (stops_of_other_.contains(report.emergency_stop)) {
    ReportViolation(Invariant::kReachesMeantMachine,
                    name + " has latched an emergency stop that is meant for another machine");
  }
  NoteLatched({name, host}, before, report);
  if (report.emergency_stop == 0 || before.emergency_stop != report.emergency_stop) return;
  if (!report.busy()) idle_and_stopped_.emplace_back(name, host);
  if (before.busy() && MaySwitchOn(config_, before.state, report.state)) {
    ReportViolation(Invariant::kEmergencyStopHolds,
                    name + " has switched from " + before.state + " to " + report.state +
                        ", which may switch it on, although it has latched an emergency stop");
  }
}

// A stop that its controller had released when the actuator received it, as after a freeze, is over
// since then: a command that was sent after the release may begin.
void Checker::NoteLatched(const std::pair<std::string, std::size_t>& actuator,
                          const ActuatorReport& before, const ActuatorReport& report) {
  const auto latches = [](const ActuatorReport& of, StopId id) {
    return of.emergency_stop == id || std::ranges::count(of.other_stops, id) != 0;
  };
  const auto note = [&](StopId id) {
    if (id == 0 || latches(before, id)) return;
    const auto released = release_order_.find(id);
    auto& order = latched_[actuator];
    order = std::max(order, released != release_order_.end() ? released->second : ++order_);
  };
  note(report.emergency_stop);
  for (const StopId id : report.other_stops) note(id);
}

// Only the release of a stop ends it.
void Checker::CheckStaysStopped(const std::string& name, const ActuatorReport& before,
                                const ActuatorReport& report) {
  const bool ended = before.emergency_stop != 0 && report.emergency_stop == 0;
  if (!ended || released_.contains(before.emergency_stop)) return;
  ReportViolation(Invariant::kEmergencyStopLatched,
                  name + " is not stopped any more, although no controller has released its stop");
}

// Whether the start of a controller takes nothing over: no other controller leads, and no process
// runs that a controller has started.
bool Checker::TakesNothingOver(const SimulatedController& controller) const {
  const auto runs = [&](const ActuatorConfig& actuator) {
    return !actuator.command.empty() &&
           robot_.processes().IsAlive(actuator.name, controller.host());
  };
  return !controller.shell().rival() && std::ranges::none_of(config_.actuators, runs);
}

// A request that leads somewhere, after a stop: a switch begins by it, or it joins one. A person's
// start that begins with the first state is one, too; so is any start once a switch up was
// requested.
void Checker::NoteRequest(const SimulatedController& controller, const action::Record& record) {
  Seen& seen = seen_[controller.serial()];
  const Machine& machine = controller.shell().machine();
  const auto note = [&](const State& from, const State& target, bool starts = false) {
    if (machine.emergency.stop) return;
    const bool up = starts || SwitchesOnAgain(config_, from, target);
    since_stop_.push_back({++order_, record.actuator, target, up});
  };
  // A start may lead up if a person has begun it since the last stop, or a switch up was requested
  // since then.
  const auto may_start = [&] {
    const std::uint64_t stopped = LastStopOf(controller.serial());
    const auto begun = begun_by_a_person_.find(controller.serial());
    return (begun != begun_by_a_person_.end() && begun->second > stopped) ||
           std::ranges::any_of(since_stop_, [stopped](const SinceStop& one) {
             return one.order > stopped && !one.actuator && one.up;
           });
  };
  switch (record.event) {
    case EventName::kSwitchRequested:
      unanswered_.erase(controller.serial());
      if (machine.current && machine.current->target == TargetOf(record)) {
        note(machine.current->from, TargetOf(record));
      }
      seen.requests.insert(record.id);
      return;
    case EventName::kPolicyRequested:
      unanswered_.erase(controller.serial());
      if (std::exchange(seen.requests_up, false)) seen.up.insert(record.id);
      seen.requests.insert(record.id);
      return;
    case EventName::kSwitchWaiting:
      seen.requests.insert(record.id);
      return;
    case EventName::kBatteryLimitsStart:  // the start leads to Active, once the battery allows it
      if (may_start()) note(machine.state, State(kActive));
      return;
    case EventName::kSwitchStarted: {
      const action::SwitchNote& begun = *record.of_switch;
      CheckStart(controller, begun);
      const bool starts = !config_.RankOf(begun.state) && may_start();
      if (!starts && !seen.requests.contains(record.cause)) return;
      // A wake-up, for one, leads up as far as the battery permits, and the battery the rest later.
      const bool up = seen.up.contains(record.cause);
      note(begun.state, up ? CeilingState(config_, BatteryLevel::kFree) : begun.target, starts);
      return;
    }
    default:
      return;
  }
}

// A start does not know whether a stop is engaged in a folder that it may not read.
void Checker::CheckStart(const SimulatedController& controller, const action::SwitchNote& begun) {
  const bool up = begun.target == kSelfCheck || Rises(config_, kDeActive, begun.target);
  if (!up || config_.RankOf(begun.state) || !unanswered_.contains(controller.serial())) return;
  ReportViolation(Invariant::kNoUnrequestedActivation,
                  "a start begins " + begun.target +
                      " although it may not read the emergency stops of another folder");
}

// When a controller last knew a stop: its disk keeps those of the controllers before it on its
// host. 0: none.
std::uint64_t Checker::LastStopOf(std::uint64_t controller) {
  std::uint64_t stopped = seen_[controller].stop_order;
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* one = robot_.controller(which);
    if (one == nullptr || one->serial() != controller || state_lost_) continue;
    stopped = std::max(stopped, stopped_on_[one->host()]);
  }
  return stopped;
}

// Whether a controller may bring an actuator to a state: it knows of no stop, or the state, or a
// more active one, was requested since the last one.
bool Checker::IsRequestedSinceStop(std::uint64_t controller, ActuatorIndex i, const State& target) {
  const std::uint64_t stopped = LastStopOf(controller);
  const auto rank = config_.RankOf(target);
  if (stopped == 0 || !rank || target == kError) return true;
  return std::any_of(since_stop_.begin(), since_stop_.end(), [&](const SinceStop& one) {
    const bool meant = !one.actuator || *one.actuator == i;
    return one.order > stopped && meant && config_.RankOf(one.target).value_or(0) >= *rank;
  });
}

// A callback that may switch the actuator on, or on again, has begun by that command.
void Checker::CheckAfterRelease(const std::string& name, std::size_t host,
                                const ActuatorReport& before, const ActuatorReport& report,
                                const SentCommand& sent) {
  // To undo a failed callback that led up leads down.
  const ActuatorCore* core = robot_.processes().CoreOf(name, host);
  const bool undoes = core != nullptr && core->unsettled && !core->half_way_down;
  const bool again =
      report.held_by_stop && !undoes && SwitchesOnAgain(config_, report.state, report.target);
  if (!again && !MaySwitchOn(config_, report.state, report.target)) return;
  if (report.target == kError || false_reporters_.contains(name)) return;
  const std::string what = name + " begins " + report.target + " in " + report.state;
  if (!sent.requested) {
    return ReportViolation(Invariant::kReleaseSwitchesNothingOn,
                           what + ", which was not requested since the last emergency stop");
  }
  const auto latched = latched_.find({name, host});
  if (latched == latched_.end() || before.incarnation != report.incarnation) return;
  if (sent.order < latched->second) {
    ReportViolation(Invariant::kReleaseSwitchesNothingOn,
                    what + ", by a command from before the emergency stop that it has latched");
  }
}

// A release was answered. Whatever was released before, no actuator that the controller leads may
// report it any more.
void Checker::CheckReleased(const SimulatedController& controller, const Result<>& released) {
  if (!released) return;
  const Machine& machine = controller.shell().machine();
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const ActuatorReport* report = robot_.ReportOf(i, machine.actuators[i].report);
    if (report == nullptr || machine.actuators[i].presence != Presence::kPresent) continue;
    if (!released_.contains(report->emergency_stop)) continue;
    ReportViolation(Invariant::kReleaseIsConfirmed,
                    "the emergency stops are reported as released, and " +
                        config_.actuators[i].name + " has latched one of them");
  }
}

// Runs after the whole step of an actuator.
void Checker::CheckPower() {
  for (const auto& [name, host] : std::exchange(idle_and_stopped_, {})) {
    const ActuatorReport* report = robot_.processes().ReportOf(name, host);
    if (report == nullptr || report->busy() || report->emergency_stop == 0) continue;
    if (!robot_.processes().IsPowered(name, host)) continue;
    ReportViolation(Invariant::kEmergencyStopHolds,
                    name + " in " + report->state +
                        " has its power on although it has latched an emergency stop");
  }
}

// --- permits to move ---

// A stop that an actuator has engaged by itself, as no permit has arrived. Nothing publishes it
// before a controller does.
void Checker::NotePermitStops(const ActuatorCore& core) {
  constexpr std::size_t kOfPermits = 50;  // beside the panels
  if (!config_.permit) return;
  for (const EmergencyStop& stop : core.stops) {
    if (stop.by != kPermitKey || engaged_.contains(stop.id)) continue;
    OnStopEngaged(kOfPermits, stop.id);
    OnStopWithdrawn(stop.id);
  }
}

// An actuator is off, by its hardware, some time after the last permit that it can have.
void Checker::CheckPermits() {
  const Time now = robot_.network().now();
  if (!config_.permit || now < check_permits_at_) return;
  check_permits_at_ = now + kPermitPeriod;
  const SimulatedProcesses& processes = robot_.processes();
  for (const ActuatorConfig& actuator : config_.actuators) {
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const ActuatorCore* core = processes.CoreOf(actuator.name, host);
      if (core == nullptr || !processes.IsPowered(actuator.name, host)) continue;
      // It was switched on by a callback whose end is not known yet; the stop action runs again.
      if (core->report.busy() && !core->stops.empty()) continue;
      const auto frozen = processes.FrozenUntil(actuator.name, host);
      if (frozen && (*frozen == Time::max() || now - *frozen < kPermitSlack)) continue;
      const auto given = permits_.find(core->permit.stamp);
      const bool known = given != permits_.end();
      if (known && now - given->second <= *config_.permit + kPermitSlack) continue;
      ReportViolation(Invariant::kStopsWithoutPermit,
                      actuator.name + " is on in " + core->report.state +
                          (known ? ' ' + std::to_string(ToMilliseconds(now - given->second)) +
                                       " ms after the last permit to move"
                                 : ", and no permit to move was given"));
    }
  }
}

// --- a TearDown, and what each controller knows ---

// An accepted TearDown continues, even if its controller ends, until a controller begins that an
// operator has started. The operator may have started it before the TearDown: it listens for other
// controllers first. Each disk stores the intent of the controllers of its host only.
void Checker::CheckStaysDown(const SimulatedController& controller) {
  const Machine& machine = controller.shell().machine();
  if (machine.stopping && !accepted_tear_down_) {
    accepted_tear_down_ = AcceptedTearDown{controller.serial(), controller.host()};
  }
  if (!accepted_tear_down_ || state_lost_ || accepted_tear_down_->host != controller.host()) return;
  const bool is_up =
      machine.phase == Phase::kRunning && accepted_tear_down_->controller != controller.serial();
  if (!is_up) return;
  ReportViolation(Invariant::kNoStartAfterTearDown,
                  "a supervisor's restart brings the machine to " + machine.state +
                      " after an accepted TearDown");
}

// Whether the actuator runs for another controller, on the host of that controller, which began
// while the controller `process`, which is to tear down, was stopped or disconnected; otherwise
// `process` would have released the machine.
bool Checker::RunsForAnother(const SimulatedController& process, ActuatorIndex i,
                             std::size_t host) const {
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* other = robot_.controller(which);
    if (other == nullptr || other->serial() == process.serial() || !other->leads()) continue;
    const std::int32_t pid = other->shell().machine().actuators[i].process.pid;
    const bool its_own =
        pid != 0 && pid == robot_.processes().PidOf(config_.actuators[i].name, host);
    if (other->host() == host && host != process.host() && its_own) return true;
  }
  return false;
}

// Notes which process of each actuator a controller has received a report of.
void Checker::NoteReceived(const SimulatedController& controller, Seen& seen) {
  const Machine& machine = controller.shell().machine();
  seen.received.resize(machine.actuators.size());
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const ActuatorReport& report = machine.actuators[i].report;
    if (report.incarnation == seen.received[i]) continue;
    seen.received[i] = report.incarnation;
    received_.insert({controller.host(), i, report.host, report.incarnation});
  }
}

// Whether a controller can know of a process on another host: it has received a report of the
// process, or an earlier controller of its host has, and has stored that. There are two cases where
// it cannot: it takes the machine over from a controller of a third host while the link to the
// process is cut, or its disk was full or stalled. A process that it never received and that no
// disk of its host has looks like a process that was never started.
bool Checker::IsKnown(const SimulatedController& controller, ActuatorIndex i, std::size_t host,
                      const ActuatorReport& report) const {
  return host == controller.host() ||
         (!state_lost_ &&
          received_.contains({controller.host(), i, report.host, report.incarnation}));
}

// TearDown is reported as done. That concerns the processes on the controller's own host, which the
// controller finds by their names, and the processes of other hosts that it can know of.
void Checker::CheckTornDown(const SimulatedController& controller, const SwitchResult& result) {
  if (result.target != kTearDown || !result.actuator.empty()) return;
  if (result.outcome != SwitchOutcome::kDone) return;
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const std::string& name = config_.actuators[i].name;
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const ActuatorReport* report = robot_.processes().ReportOf(name, host);
      if (report == nullptr || report->state == kTearDown || duplicated_.contains(name)) continue;
      const auto reported = false_reporters_.find(name);
      if (reported != false_reporters_.end() && reported->second == kTearDown) continue;
      // The controller may have no report yet of an actuator that is starting.
      const KnownActuator& known = controller.shell().machine().actuators[i];
      const bool received = known.report.incarnation == report->incarnation;
      if (!received && !config_.RankOf(report->state)) continue;
      if (!received && RunsForAnother(controller, i, host)) continue;
      if (!received && !IsKnown(controller, i, host, *report)) continue;
      ReportViolation(Invariant::kTearDownIsComplete, "TearDown is reported as done, and " + name +
                                                          " still runs in " + report->state +
                                                          " on host " + robot_.hosts().name(host));
    }
  }
}

// --- commands that wait at an actuator, clients' calls, and outcomes of switches ---

// Runs after each step of an actuator: an accepted command that waits behind a callback still
// waits, has begun, or was cancelled for a reason that its sender knows.
void Checker::CheckWaiting(const std::string& name, std::size_t host,
                           const ActuatorReport& report) {
  const ActuatorCore* core = robot_.processes().CoreOf(name, host);
  auto& known = waiting_[{name, host}];
  const std::optional<Waiting> before = known;
  known.reset();
  if (core != nullptr && core->waiting) {
    const bool same = before && before->incarnation == report.incarnation &&
                      before->command.number == core->waiting->command.number;
    const bool stopped = report.emergency_stop != 0 || (same && before->stopped);
    known = Waiting{report.incarnation, report.epoch, core->waiting->command, stopped};
  }
  if (!before || before->incarnation != report.incarnation) return;
  const SwitchCommand& command = before->command;
  if (known && known->command.number >= command.number) return;  // the same, or a newer one
  const bool begun =
      report.busy_number >= command.number || report.outcome_number >= command.number;
  const bool stopped =
      (report.emergency_stop != 0 || before->stopped) &&
      (command.target == report.state || MaySwitchOn(config_, report.state, command.target));
  if (begun || stopped || report.epoch > before->epoch || report.state == kTearDown) return;
  const auto sent = sent_commands_.find({before->epoch, *config_.IndexOf(name), command.number});
  if (sent == sent_commands_.end()) return;
  // A newer one need not have arrived: the query about it fences this one as well.
  const auto next = std::next(sent);
  const bool newer_sent = next != sent_commands_.end() &&
                          std::get<0>(next->first) == before->epoch &&
                          std::get<1>(next->first) == *config_.IndexOf(name);
  if (newer_sent || IsGivenUp(sent->first)) return;
  const Duration age = robot_.network().now() - sent->second.sent;
  if (age + kClockSlack >= sent->second.budget) return;
  ReportViolation(Invariant::kNoCommandDropped,
                  name + " drops the accepted command to " + command.target + " after " +
                      std::to_string(ToMilliseconds(age)) + " of " +
                      std::to_string(ToMilliseconds(sent->second.budget)) +
                      " ms, without a newer command");
}

// The controller has lost the actuator and reported that outcome for what it had sent.
void Checker::NoteGivenUp(Epoch epoch, ActuatorIndex i) {
  const auto after = sent_commands_.lower_bound({epoch, i + 1, CommandNumber()});
  if (after == sent_commands_.begin()) return;
  const CommandKey& last = std::prev(after)->first;
  if (std::get<0>(last) == epoch && std::get<1>(last) == i) given_up_[{epoch, i}] = last;
}

// When the actuator is available again, the query that attaches it fences a command that its
// controller has given up.
bool Checker::IsGivenUp(const CommandKey& command) const {
  const auto last = given_up_.find({std::get<0>(command), std::get<1>(command)});
  return last != given_up_.end() && command <= last->second;
}

// A controller writes a reply to a client.
void Checker::OnReplyWritten(const SimulatedController& controller, const std::string& service) {
  const Machine& machine = controller.shell().machine();
  const Time now = robot_.network().now();
  if (machine.phase == Phase::kFenced) {
    // A caller that waits gets a refusal at the moment of the fence.
    const auto fenced = fenced_at_.emplace(controller.serial(), now).first->second;
    if (now == fenced) return;
  } else if (controller.begun()) {
    return;
  }
  ReportViolation(Invariant::kOnlyLeaderReplies,
                  "a controller that does not lead replies to " + service);
}

void Checker::CheckClients() {
  const Time now = robot_.network().now();
  if (now < check_clients_at_) return;
  check_clients_at_ = now + kClientPeriod;
  for (const Client::Request* request : robot_.OpenRequests()) {
    if (!request->orphaned || request->notified || now - *request->orphaned < kNotifiedWithin)
      continue;
    ReportViolation(Invariant::kClientGetsOutcome,
                    "a client that requested " + request->target +
                        " is not notified that the controller has ended");
  }
}

void Checker::CheckClientsAtRest() {
  const Time now = robot_.network().now();
  for (const Client::Request* request : robot_.OpenRequests()) {
    if (now - request->requested < kRepliedAtRest) continue;
    ReportViolation(Invariant::kClientGetsOutcome,
                    "a client that requested " + request->target + " receives no outcome");
  }
}

void Checker::OnReply(std::uint64_t request, const SwitchResult& result) {
  ++checks_;
  const auto open = open_requests_.extract(request);
  if (open.empty()) {
    return ReportViolation(Invariant::kOneReplyPerRequest,
                           "a request for " + result.target + " got two replies");
  }
  just_replied_.insert(result.target);
  if (result.outcome == SwitchOutcome::kSuperseded && !urgent_requested_ &&
      result.code != kCodePermissionDenied) {
    ReportViolation(Invariant::kPolicyNeverSupersedes,
                    "the switch to " + result.target + " is superseded (" + result.reason +
                        "), although nothing urgent was requested");
  }
  const bool done =
      result.outcome == SwitchOutcome::kDone || result.outcome == SwitchOutcome::kDoneDegraded;
  // Beyond a partition a second controller may lead other actuators: the result is about the
  // actuators of the controller that replies.
  const SimulatedController* controller = robot_.leader();
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* replying = robot_.controller(which);
    if (replying == nullptr || replying->serial() != open.mapped().controller) continue;
    CheckTornDown(*replying, result);
    controller = replying;
  }
  const bool ranked = config_.RankOf(result.target) && result.target != kTearDown;
  if (!done || !result.actuator.empty() || !ranked || controller == nullptr) return;
  requested_state_at_ = seen_[controller->serial()].requested_state_at = robot_.age();
  const Machine& machine = controller->shell().machine();
  CheckNotDegraded(machine, result);
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const std::string& name = config_.actuators[i].name;
    const ActuatorReport* report = robot_.ReportOf(i, machine.actuators[i].report);
    if (report == nullptr || IsExcused(machine, i, result)) continue;
    if (report->state == result.target) continue;
    ReportViolation(Invariant::kDoneIsComplete, "the switch to " + result.target +
                                                    " is reported as " +
                                                    std::string(OutcomeName(result.outcome)) +
                                                    ", but " + name + " is in " + report->state);
  }
}

// Whether another controller commands the actuator since: with a higher epoch, or beyond a
// partition with the same one.
bool Checker::ObeysAnother(const Machine& machine, const ActuatorReport& report) const {
  if (report.epoch > machine.epoch) return true;
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* other = robot_.controller(which);
    if (other == nullptr || !other->leads() || &other->shell().machine() == &machine) continue;
    if (other->shell().machine().epoch >= machine.epoch) return true;
  }
  return false;
}

// Whether an actuator need not be in the state that "done" reports: it is listed as degraded, still
// joining, reports false states, joined too late to take part, or obeys a newer controller since:
// one that was frozen reports what was done before.
bool Checker::IsExcused(const Machine& machine, ActuatorIndex i, const SwitchResult& result) const {
  const std::string& name = config_.actuators[i].name;
  const KnownActuator& known = machine.actuators[i];
  const auto& degraded = result.degraded;
  if (std::find(degraded.begin(), degraded.end(), name) != degraded.end()) return true;
  const bool took_part =
      std::any_of(result.actuators.begin(), result.actuators.end(), [&](const ActuatorResult& one) {
        return one.name == name && one.outcome == ActuatorOutcome::kDone;
      });
  if (ObeysAnother(machine, *robot_.ReportOf(i, known.report))) return true;
  const bool away = known.presence != Presence::kPresent || !known.checked || known.fault;
  const bool joining = known.due || known.command || known.suspended || (away && !took_part);
  return joining || false_reporters_.contains(name) || self_switched_.contains(name) ||
         robot_.ReportOf(i, known.report)->incarnation != known.report.incarnation;
}

// "done-degraded" lists an actuator that is not available, or that failed in this switch. An
// earlier fault is neither.
void Checker::CheckNotDegraded(const Machine& machine, const SwitchResult& result) {
  if (result.outcome != SwitchOutcome::kDoneDegraded) return;
  const bool all_did =
      std::all_of(result.actuators.begin(), result.actuators.end(),
                  [](const ActuatorResult& one) { return one.outcome == ActuatorOutcome::kDone; });
  const bool all_there = std::all_of(
      machine.actuators.begin(), machine.actuators.end(), [&](const KnownActuator& known) {
        return known.presence == Presence::kPresent && known.state() == result.target;
      });
  if (!all_did || !all_there) return;
  ReportViolation(Invariant::kDoneIsComplete,
                  "the switch to " + result.target + " is reported as done-degraded (" +
                      result.reason + "), although all actuators are in that state");
}

// --- the policy, by the samples of the battery alone, not by the level that the controller derives
// from them ---

// Checked as soon as nothing else is under way. `at_rest`: the stored policy must be loaded by
// then.
void Checker::CheckCeiling(const SimulatedController& controller, bool at_rest) {
  const Machine& machine = controller.shell().machine();
  const PolicyState& policy = machine.policy;
  const bool waits = machine.current || machine.fallback.target || policy.keep || policy.power ||
                     machine.state == kOta || (!at_rest && !policy.loaded);
  if (!config_.policy || !config_.policy->battery) return;
  if (policy.battery) {
    NoteLevels(*config_.policy->battery, *policy.battery);
    level_on_[controller.host()] = {*policy.battery, policy.charging};
  }
  const auto rank = config_.RankOf(machine.state);
  if (waits || machine.phase != Phase::kRunning || !rank) return;
  // Without a sample, what the controller before it on this host knew last still holds.
  const auto known = level_on_.find(controller.host());
  if (known == level_on_.end()) return;
  if (!policy.battery && (state_lost_ || !policy.battery_silent)) return;
  const Level& level = known->second;
  const auto most = MostAt(*config_.policy->battery, level.percent, level.charging);
  if (!most || *rank <= *most) return;
  ReportViolation(Invariant::kWithinBattery,
                  "the machine is in " + machine.state + " while " +
                      (policy.battery ? BatteryText(policy)
                                      : "nothing publishes the battery, which was at " +
                                            std::to_string(level.percent) + " %"));
}

// A level is left at `hysteresis` above its threshold; from then on only the threshold counts.
void Checker::NoteLevels(const BatteryPolicy& policy, int percent) {
  const std::array begins = {policy.protected_at, policy.low_power_at};
  for (std::size_t i = 0; i < begins.size(); ++i) {
    if (percent <= begins[i]) left_[i] = false;
    if (percent >= begins[i] + policy.hysteresis && percent > begins[i]) left_[i] = true;
  }
}

// Follows the policy's decisions by their records: a decision, and then the beginning of its
// switch. Refusals of requests that wait may be between them.
void Checker::OnRecord(const action::Record& record) {
  switch (record.event) {
    case EventName::kRestartRequested:
      config_errors_.erase(config_.actuators[*record.actuator].name);
      return;
    case EventName::kPolicyRequested:
    case EventName::kSwitchRequested:
      // A request that ends in the same step never shows as the switch under way.
      if (!record.actuator && !TargetOf(record).empty()) just_replied_.insert(TargetOf(record));
      if (record.event == EventName::kPolicyRequested) power_requested_ = record.id;
      return;
    case EventName::kPowerOffStarted:
      return CheckPowerOffStarted(record);
    case EventName::kSwitchStarted:
      if (std::exchange(lowering_begins_, false)) NoteLowering(record.of_switch->state);
      return;
    case EventName::kBatteryLimitsStart:  // which would have led to Active
      lowered_ = {State(kActive), TargetOf(record)};
      lowered_on_[recording_host_] = State(kActive);
      return;
    case EventName::kBatterySwitchUp:
      policy_up_to_.push_back(TargetOf(record));
      raised_at_ = PercentOf(record);
      return;
    case EventName::kBatterySwitchDown:
      policy_down_to_.push_back(TargetOf(record));
      lowering_begins_ = true;
      return;
    case EventName::kLyingStillSwitch:
      policy_down_to_.push_back(TargetOf(record));
      lowering_begins_ = false;
      lowered_.reset();
      return;
    default:
      return;
  }
}

// The battery takes the machine down from the state `from`.
void Checker::NoteLowering(const State& from) {
  // The raise to `from` has ended in this step.
  if (std::erase(policy_up_to_, from) != 0) {
    CheckRaise(from, raised_at_.value_or(0));
    checked_raise_ = from;
  }
  if (!lowered_ || lowered_->second != from) lowered_ = {from, from};
  lowered_on_[recording_host_] = lowered_->first;
  lowered_->second = policy_down_to_.back();
}

bool Checker::ByPolicy(const State& state) const {
  const auto has = [&](const std::vector<State>& all) {
    return std::find(all.begin(), all.end(), state) != all.end();
  };
  return has(policy_up_to_) || has(policy_down_to_) || checked_raise_ == state;
}

// The machine's state has changed.
void Checker::CheckPolicyChange(const Machine& machine, const Seen& seen) {
  const auto before = config_.RankOf(seen.state);
  if (!config_.policy || !before) return;  // a step of a start
  if (std::exchange(checked_raise_, std::nullopt) == machine.state) return;
  if (ByPolicy(machine.state)) {
    const bool up = std::erase(policy_up_to_, machine.state) != 0;
    const bool down = std::erase(policy_down_to_, machine.state) != 0;
    // The battery may have fallen during the switch.
    const int percent = raised_at_.value_or(machine.policy.battery.value_or(0));
    if (up && !down) CheckRaise(machine.state, percent);
    return ForgetEndedPolicySwitches(machine);  // several may have ended in one step
  }
  if (lowered_ && lowered_->first == machine.state) {  // it is lowered from here at once
    if (std::exchange(raise_requested_, false)) lowered_->first = State(kActive);
    return;
  }
  // A client requested this switch. The policy may raise the machine later, or has begun to: the
  // battery may have left its ceiling in the step that ended this switch.
  ForgetEndedPolicySwitches(machine);
  lowered_.reset();
  if (std::exchange(raise_requested_, false)) lowered_ = {State(kActive), machine.state};
}

void Checker::OnBattery(int percent, bool charging) {
  const auto& battery = config_.policy ? config_.policy->battery : std::nullopt;
  if (battery && percent <= battery->tear_down_at && !charging) {
    most_empty_in_a_row_ = std::max(most_empty_in_a_row_, ++empty_in_a_row_);
    return;
  }
  // A controller that does not receive this sample takes the next empty one for the second.
  const SimulatedController* leading = robot_.leader();
  const bool well =
      !link_faults_until_ || *link_faults_until_ < robot_.network().now() - kReceivedAfter;
  const bool received = leading != nullptr && !leading->frozen && well;
  if (received) empty_in_a_row_ = 0;
}

// By a request, or because the battery is empty.
void Checker::CheckPowerOffStarted(const action::Record& record) {
  if (record.cause == power_requested_ || most_empty_in_a_row_ > 1) return;
  ReportViolation(Invariant::kNotOffByOneSample, "the robot is powered off after " +
                                                     std::to_string(most_empty_in_a_row_) +
                                                     " samples in a row of an empty battery");
}

// By the samples that the controller knows, not by the level that it derives from them.
void Checker::CheckQuiet(const Machine& machine, Seen& seen) {
  if (!config_.policy || !config_.policy->battery) return;
  const BatteryPolicy& battery = *config_.policy->battery;
  const Time now = robot_.network().now();
  for (const BatterySource& source : machine.policy.batteries) {
    const auto most = MostAt(battery, source.percent, source.charging);
    if (!most) continue;
    seen.protected_at = now;
    if (*most < *BuiltInRank(kProtected)) seen.low_power_at = now;
  }
  const auto& s = machine.current;
  const bool raises = s && s->purpose == Purpose::kPolicy && s->direction == Direction::kUp;
  if (!raises || std::exchange(seen.raise, s->number) == s->number) return;
  const auto rank = config_.RankOf(s->target);
  const auto check = [&](const std::optional<Time>& lower_at, std::string_view most) {
    if (!lower_at || now >= *lower_at + battery.raise_after || *rank <= *BuiltInRank(most)) return;
    ReportViolation(Invariant::kRaisedAfterQuiet,
                    "the policy raises the machine to " + s->target + ' ' +
                        std::to_string(ToMilliseconds(now - *lower_at)) +
                        " ms after a sample that permits " + std::string(most));
  };
  check(seen.low_power_at, kLowPower);
  check(seen.protected_at, kProtected);
}

void Checker::ForgetEndedPolicySwitches(const Machine& machine) {
  const auto ended = [&](const State& target) {
    return !machine.current || machine.current->purpose != Purpose::kPolicy ||
           machine.current->target != target;
  };
  std::erase_if(policy_up_to_, ended);
  std::erase_if(policy_down_to_, ended);
}

void Checker::CheckRaise(const State& raised_to, int percent) {
  const Rank rank = *config_.RankOf(raised_to);
  const std::string what = "the policy has raised the machine to " + raised_to;
  // A controller of another host may have led in between, of which this one does not know.
  const auto own = lowered_on_.find(recording_host_);
  const bool by_own = !robot_.OneHost() && own != lowered_on_.end() &&
                      rank <= config_.RankOf(own->second).value_or(0);
  const bool back = by_own || (lowered_ && rank <= config_.RankOf(lowered_->first).value_or(0));
  if (!back && !state_lost_) {
    ReportViolation(Invariant::kNoFlapping, what + ", which it had not lowered from there");
  }
  const BatteryPolicy& battery = *config_.policy->battery;
  const std::tuple<std::string_view, int, bool> levels[] = {
      {kProtected, battery.protected_at, left_[0]}, {kLowPower, battery.low_power_at, left_[1]}};
  for (const auto& [state, at, left] : levels) {
    // It may have been left before: a raise is retried after one that was undone.
    const bool still_left = left && percent > at;
    if (rank <= *BuiltInRank(state) || percent >= at + battery.hysteresis || still_left) continue;
    ReportViolation(Invariant::kNoFlapping, what + " at " + std::to_string(percent) + " %");
  }
  if (!lowered_) return;
  lowered_->second = raised_to;
  if (lowered_->first == raised_to) lowered_.reset();
}

std::uint64_t Checker::OnPolicyRequest(const SimulatedController& controller,
                                       const event::PolicyRequested& requested) {
  const bool up = requested.what == PolicyRequest::kWakeUp ||
                  (requested.what == PolicyRequest::kOta && !requested.enable) ||
                  (requested.what == PolicyRequest::kLowPowerSwitch && !requested.enable);
  raise_requested_ |= up;
  seen_[controller.serial()].requests_up = up;
  return OnRequest(controller,
                   requested.what == PolicyRequest::kKeep ? requested.state : State(kActive));
}

void Checker::OnPolicyReply(std::uint64_t request, const event::PolicyRequested& requested,
                            const Result<>& reply) {
  ++checks_;
  if (open_requests_.erase(request) == 0) {
    return ReportViolation(Invariant::kOneReplyPerRequest,
                           "a request to the policy got two replies");
  }
  just_replied_.insert(requested.what == PolicyRequest::kKeep ? requested.state : State(kActive));
  if (!reply) return;
  const bool alone = robot_.controller(1) == nullptr;
  if (requested.what == PolicyRequest::kPowerOff && !power_due_ && alone) {
    power_due_ = robot_.network().now() + config_.policy->power.force_after + kPowerSlack;
  }
}

// --- by the clock that the policy follows ---

// Jumps do not count; of two in a row, the second one does.
void Checker::OnClock(Time time) {
  const Time now = robot_.network().now();
  const Duration step = clock_ ? time - *clock_ : Duration::zero();
  const bool counts =
      step > Duration::zero() && (step <= kLongestStep || clock_step_ > kLongestStep);
  if (counts) clock_passed_ += step;
  clock_step_ = step;
  clock_ = time;
  clock_samples_.emplace_back(now, clock_passed_);
  while (clock_samples_.size() > 1 && clock_samples_[1].first <= now - kClockLag) {
    clock_samples_.pop_front();
  }
}

Duration Checker::PolicyTime() const {
  const bool by_topic = config_.clock == ClockSource::kTopic;
  return by_topic ? clock_passed_ : robot_.network().now().time_since_epoch();
}

// The last samples of /clock may be on their way to the controller.
Checker::Mark Checker::MarkNow() const {
  const Time now = robot_.network().now();
  if (config_.clock == ClockSource::kSteady) return {now, now.time_since_epoch()};
  Duration passed = clock_samples_.empty() ? Duration::zero() : clock_samples_.front().second;
  for (const auto& [at, by_clock] : clock_samples_) {
    if (at <= now - kClockLag) passed = by_clock;
  }
  return {now, passed};
}

// A sample of the body is published.
void Checker::OnMotion(std::int32_t motion) {
  if (!config_.policy || !config_.policy->low_power) return;
  const std::vector<std::int32_t>& ids = config_.policy->low_power->motion_ids;
  if (std::ranges::find(ids, motion) != ids.end()) {
    if (!still_) still_ = MarkNow();
    return;
  }
  if (!still_) return;
  if (!JustMoved()) still_before_ = still_;
  moved_at_ = robot_.network().now();
  still_.reset();
}

// A controller may not have received that it moves.
bool Checker::JustMoved() const {
  return moved_at_ && robot_.network().now() - *moved_at_ <= kClockLag;
}

void Checker::NotePolicyTimes(const SimulatedController& controller, Seen& seen) {
  const Machine& machine = controller.shell().machine();
  const bool awake = machine.state == kActive || machine.state == kProtected;
  const auto& keep = machine.policy.keep;
  if (!awake || keep) {
    seen.awake.reset();
  } else if (!seen.awake) {
    seen.awake = MarkNow();
  }
  if (!keep) {
    seen.kept.reset();
  } else if (!seen.kept) {
    seen.kept = MarkNow();
    seen.kept_for_s = keep->seconds;
  }
}

// nullopt: one of them is not so.
std::optional<Checker::Mark> Checker::LaterOf(const std::optional<Mark>& a,
                                              const std::optional<Mark>& b) {
  if (!a || !b) return std::nullopt;
  return a->at < b->at ? b : a;
}

// What the policy does by time. The state before is as it was seen after the step before.
void Checker::CheckPolicyTime(const SimulatedController& controller, const action::Record& record) {
  const Seen& seen = seen_[controller.serial()];
  switch (record.event) {
    case EventName::kLyingStillSwitch:
      return CheckWaited(controller, LaterOf(seen.awake, JustMoved() ? still_before_ : still_),
                         config_.policy->low_power->lying_still, "takes the machine to LowPower");
    case EventName::kKeepEnded:
      if (ArgumentOf(record.arguments, "reason") != "time expired") return;
      return CheckWaited(controller, seen.kept, std::chrono::seconds(seen.kept_for_s),
                         "ends what keeps the machine");
    default:
      return;
  }
}

void Checker::CheckWaited(const SimulatedController& controller, const std::optional<Mark>& since,
                          Duration limit, const std::string& what) {
  const Time now = robot_.network().now();
  // What a controller has received late, or not at all, it times by itself.
  const Time from = since ? since->at - std::chrono::seconds(1) : now;
  const bool late = (link_faults_until_ && *link_faults_until_ >= from) || controller.frozen ||
                    (controller.thawed && *controller.thawed >= from);
  if (late) return;
  const Duration waited = since ? PolicyTime() - since->by_clock : Duration::zero();
  if (waited + Milliseconds(1) >= limit) return;
  ReportViolation(Invariant::kNotBeforeItsTime,
                  "the policy " + what + " after " + std::to_string(ToMilliseconds(waited)) +
                      " of " + std::to_string(ToMilliseconds(limit)) + " ms by its clock");
}

void Checker::OnControllersBlocked(bool state_lost) {
  power_due_.reset();
  state_lost_ |= state_lost;
}

void Checker::CheckPowerOff() {
  if (!power_due_ || robot_.network().now() <= *power_due_) return;
  ReportViolation(Invariant::kPowerOffInTime, "the accepted power-off has not happened in time");
}

// --- what is under way, and a stable state ---

// What an actuator will do by itself; empty: nothing.
std::string Checker::PendingActivity(const Machine& machine, ActuatorIndex i) const {
  const KnownActuator& r = machine.actuators[i];
  const bool alive = robot_.IsAlive(config_.actuators[i].name);
  if (r.set_up_by && r.presence != Presence::kPresent && alive) return "is being set up";
  if (r.fault && !r.command && !r.restart.at && !r.process.termination && !r.restart.requested)
    return {};
  if (r.command) return "has a command to " + r.command->target;
  if (r.restart.at || r.restart.requested) return "is to be restarted";
  if (r.process.termination) return "is to be killed";
  if (r.free_by) return "is busy with the callback that it was found in";
  if (r.control.again && r.presence == Presence::kStarting && alive) return "is being attached";
  const bool waits = machine.emergency.stop || r.held || machine.phase != Phase::kRunning ||
                     r.presence != Presence::kPresent;
  return r.due && !waits ? "is to be switched to the machine's state" : "";
}

std::string Checker::PendingActivity() const {
  const SimulatedController* controller = robot_.leader();
  if (controller == nullptr) return "no controller leads the machine";
  if (robot_.leaders() > 1) return "two controllers lead the machine";
  const Machine& machine = controller->shell().machine();
  if (machine.phase == Phase::kStopped) return {};
  if (machine.current) return "a switch to " + machine.current->target + " is under way";
  if (machine.policy.keep) return "an application keeps it in " + machine.policy.keep->state;
  if (machine.policy.power) return "the robot is being powered off";
  const PolicyState& policy = machine.policy;
  if (ConfirmedAt(policy.lifting, {})) return "the battery is about to lift its ceiling";
  if (ConfirmedAt(policy.emptying, {}) && !policy.empty) return "it is about to be powered off";
  const bool unknown = !policy.battery && policy.level != BatteryLevel::kFree;
  if (unknown && !policy.battery_silent) return "the battery may be silent";
  if (machine.policy.still_since) return "it is about to go to LowPower";
  if (machine.emergency.release) return "the release of an emergency stop is being confirmed";
  if (machine.fallback.target) return "it is about to fall back to " + *machine.fallback.target;
  if (machine.phase != Phase::kRunning && machine.phase != Phase::kFailed) {
    return "the machine is " + std::string(PhaseName(machine.phase));
  }
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    const std::string activity = PendingActivity(machine, i);
    if (!activity.empty()) return config_.actuators[i].name + " " + activity;
  }
  return {};
}

void Checker::CheckRest(bool provided) {
  const SimulatedController* controller = robot_.leader();
  if (controller == nullptr) return;
  ++checks_;
  const Machine& machine = controller->shell().machine();
  if (!open_requests_.empty()) {
    ReportViolation(Invariant::kOneReplyPerRequest,
                    "a request for " + open_requests_.begin()->second.target + " has no reply");
  }
  CheckCeiling(*controller, true);
  if (machine.phase != Phase::kStopped) {
    CheckStopsAtRest(machine);
    CheckClientsAtRest();
  }
  for (const ActuatorIndex i : machine.actuators.Indices()) {
    if (machine.phase == Phase::kStopped) {
      const std::string& name = config_.actuators[i].name;
      const bool here = robot_.processes().IsAlive(name, controller->host());
      if (!config_.actuators[i].command.empty() && here) {
        ReportViolation(Invariant::kTearDownEndsProcesses,
                        "the process of " + name + " outlives the machine");
      }
      continue;
    }
    CheckPlaceInStart(machine, i);
    if (machine.phase != Phase::kRunning) continue;
    CheckRunsOnce(config_.actuators[i].name);
    CheckPlace(machine, i);
    CheckLoss(machine, i, provided);
  }
  CheckStableRules(machine);
}

// What an actuator that publishes a false state is in, is not known.
void Checker::CheckStableRules(const Machine& machine) {
  if (machine.phase == Phase::kStopped || !false_reporters_.empty()) return;
  const auto state_of = [&](std::optional<ActuatorIndex> actuator) {
    if (!actuator) return machine.state;
    const ActuatorReport* report = robot_.ReportOf(*actuator, machine.actuators[*actuator].report);
    return report == nullptr ? State() : report->state;
  };
  for (const StableRule& rule : stable_rules) {
    if (rule.IsViolated(state_of)) ReportViolation(Invariant::kStableRules, rule.text);
  }
}

void Checker::CheckPlace(const Machine& machine, ActuatorIndex i) {
  const KnownActuator& known = machine.actuators[i];
  const std::string& name = config_.actuators[i].name;
  const ActuatorReport* report = robot_.ReportOf(i, known.report);
  if (report == nullptr || known.held || known.fault || false_reporters_.contains(name)) return;
  const auto own = config_.RankOf(report->state);
  const auto rank = config_.RankOf(machine.state);
  const bool waits = machine.emergency.stop && (!own || (rank && *own < *rank));
  if (machine.emergency.stop && known.presence == Presence::kPresent &&
      report->emergency_stop == 0) {
    ReportViolation(Invariant::kEmergencyStopHolds, name + " has not latched the emergency stop");
  }
  if (report->state == machine.state || waits || !rank) return;
  if (config_.actuators[i].stage > machine.start_up.stage && known.presence == Presence::kAbsent)
    return;
  ReportViolation(Invariant::kStatesAgree, name + " is in " + report->state +
                                               " while the machine is in " + machine.state +
                                               ", without a recorded reason");
}

// In a step of a start, even a failed start, the machine has no state for its actuators.
// They stay where a rollback leads: in DeActive or else LowPower, or less active. One that cannot
// be brought there is listed.
void Checker::CheckPlaceInStart(const Machine& machine, ActuatorIndex i) {
  const KnownActuator& known = machine.actuators[i];
  const ActuatorConfig& actuator = config_.actuators[i];
  const ActuatorReport* report = robot_.ReportOf(i, known.report);
  if (config_.RankOf(machine.state) || known.presence != Presence::kPresent || known.held) return;
  if (report == nullptr || report->busy() || false_reporters_.contains(actuator.name)) return;
  const bool rests = actuator.Lists(kDeActive) || actuator.Lists(kLowPower);
  const State most(actuator.Lists(kDeActive) || !rests ? kDeActive : kLowPower);
  if (!config_.RankOf(report->state) || !Falls(config_, report->state, most)) return;
  // Where it was to be brought back, its callback has failed, or it must not be commanded.
  const bool fails = !rests || report->outcome_code != kCodeOk || known.health == Health::kHung ||
                     known.restart.given_up;
  if (known.fault && fails) return;
  ReportViolation(Invariant::kStatesAgree, actuator.name + " stays in " + report->state +
                                               " while the machine is in " + machine.state);
}

void Checker::CheckLoss(const Machine& machine, ActuatorIndex i, bool provided) {
  const KnownActuator& known = machine.actuators[i];
  const ActuatorConfig& actuator = config_.actuators[i];
  const auto rank = config_.RankOf(machine.state);
  if (known.presence == Presence::kPresent || known.held || !rank) return;
  if (known.presence == Presence::kAbsent && machine.emergency.stop) return;  // of a later stage
  if (!actuator.on_lost.empty()) {
    if (*rank <= *config_.RankOf(actuator.on_lost)) return;
    // An operator may continue without an actuator that is not critical. Beyond a cut link another
    // controller may have it longer.
    const Seen& seen = seen_[SerialOf(machine)];
    const bool goes_on = seen.lost_at.Has(i) && seen.requested_state_at >= seen.lost_at[i];
    if (!actuator.critical && goes_on) return;
    return ReportViolation(
        actuator.critical ? Invariant::kSafeWithoutCritical : Invariant::kOnLostCoversLoss,
        "the machine stays in " + machine.state + " without " + actuator.name +
            ", whose on_lost is " + actuator.on_lost);
  }
  if (!provided || actuator.command.empty()) return;  // others are not started by the controller
  ReportViolation(Invariant::kOnLostCoversLoss,
                  "the machine stays in " + machine.state + " without " + actuator.name + ", " +
                      (known.restart.given_up
                           ? (known.restart.count < actuator.restart.limit
                                  ? "which is not restarted after its exit code"
                                  : "which was given up after " +
                                        std::to_string(known.restart.count) + " restarts")
                           : (robot_.IsAlive(actuator.name) ? "which hangs, and is not killed"
                                                            : "which is not restarted")) +
                      "; it has no on_lost (\"Active\" if the machine may run without it)");
}

}  // namespace musher::simulation
