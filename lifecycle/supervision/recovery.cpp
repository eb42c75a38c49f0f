#include "musher/lifecycle/supervision/recovery.hpp"

#include <utility>

#include "musher/lifecycle/refusal.hpp"

namespace musher {
namespace {

// For so long a start awaits a critical actuator whose host boots: later it would be no start that
// a person still expects.
constexpr Duration kHostBoots = Milliseconds(180'000);

// For so long an actuator on another host may be silent alone there before its process is killed:
// three heartbeats are soon missed on a radio link.
constexpr Duration kSilence = Milliseconds(5000);
// After a cut the processes of a host are discovered one after the other.
constexpr Duration kDiscovered = Milliseconds(20'000);
constexpr Duration kLate = Milliseconds(100);

void EndLaunch(KnownActuator& known) {
  const Launch launch = known.process.launch;
  if (launch == Launch::kUnderWay || launch == Launch::kAwaitsHost) {
    known.process.launch = Launch::kNone;
  }
}

}  // namespace

void Recovery::On(const event::HealthChanged& changed) {
  const ActuatorIndex i = changed.actuator;
  KnownActuator& known = Of(i);
  if (changed.incarnation != known.report.incarnation ||
      changed.incarnation == known.process.dead || machine_.phase == Phase::kStopping) {
    return;
  }
  if (changed.health == Health::kWell) return Recovered(i, changed.how);
  // Torn down alone it sends no heartbeat. Its process may run on for another actuator, or save.
  if (known.state() == kTearDown && known.writer_lost) return;
  const bool cut = std::exchange(known.health, changed.health) == Health::kPartitioned;
  const RecordText what = texts::Unhealthy(changed.health, changed.how);
  switch (changed.health) {
    case Health::kHung:
      return commands_.MarkHung(i, changed.silent, what);
    case Health::kCrashed:
    case Health::kPartitioned:
      return Silent(i, what, cut ? kDiscovered : kSilence);
    case Health::kStarved:
    case Health::kWell:
      RecordActuator(i, kCodeTimeout, texts::ActuatorStarved(ConfigOf(i).name, changed.how));
      return;
  }
}

// On another host. A silent process is none that has just exited.
void Recovery::Silent(ActuatorIndex i, const RecordText& how, Duration timeout) {
  KnownActuator& known = Of(i);
  if (known.presence == Presence::kPresent || known.presence == Presence::kStarting) {
    commands_.LoseConnection(i, how);
    if (known.report.host != machine_.host && known.exit_by) {
      known.exit_by.reset();
      FallBack(i);
    }
  }
  auto& termination = known.process.termination;
  if (known.health == Health::kPartitioned) {
    // The silence of it alone was the begin of the cut.
    if (termination && termination->for_silence && !termination->killed) termination.reset();
    return;
  }
  // It alone: its process is frozen, or its connection is bad for a moment.
  const std::int32_t pid = ProcessOf(i);
  const bool known_there = !known.process.host.empty() && pid != 0 && IsReportOf(i, pid);
  if (!known_there || !MayRestart(i) || termination) return;
  processes_.Terminate(i, pid, timeout);
  termination->for_silence = true;
}

void Recovery::Recovered(ActuatorIndex i, const std::string& how) {
  KnownActuator& known = Of(i);
  known.health = Health::kWell;
  // Until it is attached it may be heard and never answer.
  if (known.exit_by) known.exit_by = now_ + kExitIsKnown;
  known.cause =
      RecordActuator(i, kCodeOk, texts::ActuatorRecovered(ConfigOf(i).name, how), known.cause);
  if (!known.restart.requested) known.process.termination.reset();  // else it is terminated anyway
  if (known.presence == Presence::kLost) {
    known.presence = Presence::kStarting;
    return control_.Take(i);
  }
  if (known.presence == Presence::kPresent && known.fault && known.checked && !known.held) {
    known.due = true;
  }
}

void Recovery::On(const event::BacktraceTaken& taken) {
  KnownActuator& known = Of(taken.actuator);
  const auto& termination = known.process.termination;  // none: it has recovered, or has exited
  if (!termination || termination->pid != taken.pid || termination->killed) return;
  action::Record backtrace;
  backtrace.kind = "process";
  backtrace.actuator = taken.actuator;
  const RecordText text = texts::BacktraceTaken(ConfigOf(taken.actuator).name);
  backtrace.message = text.message;
  backtrace.event = text.event;
  backtrace.arguments = text.arguments;
  backtrace.cause = known.cause;
  backtrace.data = taken.text;
  Record(backtrace);
  processes_.Kill(taken.actuator);
}

// Its exit was not seen, or the kernel delays it. If it still runs, its successor will report that.
void Recovery::AssumeExited(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  const std::int32_t pid = known.process.termination->pid;
  // The systemd of another host reports each exit: until then the signal may not have reached it.
  if (!known.process.host.empty() && known.process.pid == pid) {
    known.process.termination->kill_at = now_ + kEndTime;
    // Its host may be out of reach, and the machine does not wait for that.
    if (!std::exchange(known.process.termination->overdue, true)) FallBack(i);
    return Do(action::SignalProcess{i, pid, true});
  }
  RecordProcess(i, kCodeTimeout, texts::ProcessExitAssumed(pid));
  if (known.process.pid == pid) processes_.ForgetProcess(i);
  known.process.dead = known.report.incarnation;
  if (known.presence == Presence::kPresent) commands_.Lose(i, texts::Killed());
  processes_.Recover(i);
}

void Recovery::EndNow(ActuatorIndex i) {
  auto& termination = Of(i).process.termination;
  if (termination->killed) return AssumeExited(i);
  if (!termination->for_silence) return processes_.Kill(i);
  // This controller was stopped itself, and may not have read yet what has been received.
  if (now_ - termination->kill_at > kLate) {
    termination->kill_at = now_ + kSilence;
    return;
  }
  processes_.Kill(i);
}

// Whether it has exited is not known in time, or it is heard again and does not answer.
void Recovery::FallBackWithout(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  const auto& termination = known.process.termination;
  const bool is_ended = known.restart.at || (termination && !termination->for_silence);
  const ControlState& control = known.control;
  const bool is_queried =
      known.presence == Presence::kStarting && control.again && !control.rival_until;
  const bool lost = (known.presence == Presence::kLost || is_queried) && !is_ended;
  // It waits for a CPU, or a debugger holds it: it is examined again.
  const bool waits = lost && known.health == Health::kStarved;
  known.exit_by = waits ? std::optional(now_ + kExitIsKnown) : std::nullopt;
  if (lost && !waits) FallBack(i);
}

void Recovery::CheckDeadlines() {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    KnownActuator& known = Of(i);
    if (auto& termination = known.process.termination) {
      if (termination->terminate_at && *termination->terminate_at <= now_) {
        termination->terminate_at.reset();
        Do(action::SignalProcess{i, termination->pid, false});
      }
      if (termination->kill_at <= now_) EndNow(i);
    }
    if (known.exit_by && *known.exit_by <= now_) FallBackWithout(i);
    if (known.restart.reset_at && *known.restart.reset_at <= now_) {
      known.restart.reset_at.reset();
      known.restart.count = 0;
      if (std::exchange(known.restart.given_up, false)) known.due = known.checked;
    }
    if (known.restart.at && *known.restart.at <= now_) processes_.StartAgain(i);
    if (ConfigOf(i).restart.finalized) RestartFinalized(i);
    if (!known.restart.requests.empty()) AnswerRestarts(i);
  }
}

// Another client has finalized the ROS 2 node: its process keeps running, but only a new process
// can be configured. Replaces the process at most as often in a row as [restart] permits.
void Recovery::RestartFinalized(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  const bool running = machine_.phase == Phase::kRunning || machine_.phase == Phase::kFailed;
  const bool finalized = known.presence == Presence::kPresent && known.state() == kTearDown &&
                         !known.held && !known.report.detached && !known.command;
  const bool ending = known.restart.requested || known.process.termination.has_value();
  const RestartConfig& restart = ConfigOf(i).restart;
  if (!running || !finalized || ending || machine_.current || ProcessOf(i) == 0 ||
      known.restart.count >= restart.limit) {
    return;
  }
  ++known.restart.count;
  known.restart.requested = true;
  known.cause = RecordProcess(i, kCodeOk,
                              texts::RestartScheduled(ConfigOf(i).name, Duration::zero(),
                                                      known.restart.count, restart.limit),
                              known.cause);
  EndForRestart(i);
}

void Recovery::On(const event::ProcessStarted& started) {
  KnownActuator& known = Of(started.actuator);
  known.process.pid = started.pid;
  known.process.host = started.host;
  EndLaunch(known);
  // The exit was a false report: the process that has published still runs.
  const ActuatorReport& report = known.report;
  const bool reported = !started.host.empty() && report.host == started.host &&
                        (report.pid == started.pid || report.pid == 0);
  if (started.found && reported) known.process.dead = 0;
  if (started.pid == known.process.ended_pid) known.process.ended_pid = 0;
  const ActuatorConfig& config = ConfigOf(started.actuator);
  known.cause = RecordProcess(
      started.actuator, kCodeOk,
      started.host.empty()
          ? texts::ProcessStarted(config.name, started.pid)
          : texts::ProcessStartedOn(config.host, config.name, started.pid, started.found),
      known.cause);
  // The machine was torn down while the process was starting.
  const bool stopped = machine_.phase == Phase::kStopped;
  if (!stopped && machine_.phase != Phase::kStopping) return BeginLateSetUp(started);
  // TearDown commands it, and SignalProcesses() ends it if it does not exit after that.
  const bool driven =
      started.found && !stopped && machine_.stopping->sent == Shutdown::Signal::kNone &&
      (known.presence == Presence::kPresent || known.presence == Presence::kStarting);
  if (driven) return;
  Do(action::SignalProcess{started.actuator, started.pid,
                           stopped || machine_.stopping->sent == Shutdown::Signal::kKill});
}

// A process that has waited for its host is set up within the usual time.
void Recovery::BeginLateSetUp(const event::ProcessStarted& started) {
  KnownActuator& known = Of(started.actuator);
  const bool waited = known.fault && known.fault->event == EventName::kProcessNotStarted;
  const bool runs_on = started.found && known.presence != Presence::kAbsent;
  if (started.host.empty() || !waited || runs_on || known.presence == Presence::kPresent) return;
  known.presence = Presence::kStarting;
  known.set_up_by = now_ + config_.TimeFor(started.actuator, kSetUp);
}

// Possibly after its process was forked and could not execute the program.
void Recovery::On(const event::ProcessNotStarted& failed) {
  processes_.ForgetProcess(failed.actuator);
  EndLaunch(Of(failed.actuator));
  // Another party has started it.
  const bool announced = Of(failed.actuator).control.again.has_value();
  if (Of(failed.actuator).presence == Presence::kPresent || announced) return;
  // On a host that is out of reach, the process that has published may run on.
  const ActuatorReport& report = Of(failed.actuator).report;
  // Another one has appeared on another host, beyond a link that was cut.
  const bool runs_elsewhere =
      RunsElsewhere(failed.actuator) && report.incarnation != Of(failed.actuator).process.dead;
  const bool may_run = !ConfigOf(failed.actuator).host.empty() && report.incarnation != 0 &&
                       report.incarnation != Of(failed.actuator).process.dead;
  Of(failed.actuator).presence = may_run ? Presence::kLost : Presence::kAbsent;
  const auto& fault = Of(failed.actuator).fault;
  const bool again = fault && fault->event == EventName::kProcessNotStarted;
  Degrade(failed.actuator, kCodeFailed, texts::ProcessNotStarted(failed.why),
          Of(failed.actuator).cause);
  if (failed.waits) return AwaitHost(failed.actuator, again);
  if (!runs_elsewhere) return processes_.Recover(failed.actuator);
  Of(failed.actuator).presence = Presence::kLost;
  FallBack(failed.actuator);
}

// Nothing was executed, so this does not count as a restart. The loss of the actuator takes the
// machine down once: after that a person may have continued without it.
void Recovery::AwaitHost(ActuatorIndex i, bool again) {
  KnownActuator& known = Of(i);
  known.process.launch = Launch::kAwaitsHost;
  known.process.termination.reset();
  known.restart.requested = false;
  if (again) return;
  const bool starts = machine_.phase == Phase::kStarting && !machine_.start_up.finishing;
  if (starts && Critical(i)) known.set_up_by = now_ + kHostBoots;
  FallBack(i);
}

void Recovery::On(const event::ProcessEnded& ended) {
  KnownActuator& known = Of(ended.actuator);
  if (known.process.pid != ended.pid) return;
  const bool another = AnotherProcessIsPresent(ended.actuator, ended.pid);
  if (IsReportOf(ended.actuator, ended.pid)) {
    known.process.dead = known.report.incarnation;
  } else {
    known.process.ended_pid = ended.pid;
    known.process.ended_host = HostOf(ended.actuator);
  }
  const bool second =
      known.other && known.other->pid == ended.pid && known.other->host == HostOf(ended.actuator);
  if (second) known.other.reset();
  processes_.ForgetProcess(ended.actuator);
  // It ran before this controller, and has reported nothing: it may have been in any state.
  const bool is_unknown = known.process.launch == Launch::kFoundRunning &&
                          known.report.incarnation == 0 && !known.down_requested;
  if (is_unknown && !ended.clean && known.lost_in.empty()) known.lost_in = State(kUnknownState);
  // The host was reached again during TearDown.
  const bool had_no_answer = !ConfigOf(ended.actuator).host.empty() && known.fault &&
                             known.fault->event == EventName::kMayStillRun;
  if (had_no_answer) known.fault.reset();
  known.cause =
      RecordProcess(ended.actuator, ended.clean ? kCodeOk : kCodeFailed,
                    texts::ProcessExited(ConfigOf(ended.actuator).name, ended.pid, ended.how),
                    known.fault ? known.cause : 0);
  if (another) {
    // Without its host the pid would name a process of this host.
    const auto& termination = known.process.termination;
    if (termination && termination->pid == ended.pid) processes_.ForgetEnd(ended.actuator);
    return;
  }
  if (ended.clean) commands_.AssumeTornDown(ended.actuator);
  // A clean exit that was not requested is a loss, but not a crash.
  if (known.health != Health::kHung && !ended.clean) known.health = Health::kCrashed;
  const bool in_set_up = known.presence == Presence::kStarting;
  const RecordText why = processes_.IsFinal(ended.actuator, ended)
                             ? processes_.WhyFinal(ended)
                             : texts::Exited(ended.pid, ended.how, ended.clean, in_set_up);
  if (in_set_up || known.presence == Presence::kPresent) {
    const bool final = processes_.IsFinal(ended.actuator, ended);
    commands_.Lose(ended.actuator, why, known.cause, final ? kCodeFailed : kCodeNetError);
  } else if (WasDisconnected(ended.actuator)) {
    // The lost connection was the first sign of the exit.
    Degrade(ended.actuator, known.fault->code, why, known.cause);
  }
  commands_.StayDown(ended.actuator);
  processes_.Recover(ended.actuator, ended);
}

// Whether the actuator is lost, and a lost connection is the only reason that is known.
bool Recovery::WasDisconnected(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  return known.presence == Presence::kLost && known.fault &&
         known.fault->event == EventName::kConnectionLost;
}

// --- restarts that a person requests ---

void Recovery::On(const event::RestartRequested& requested) {
  const auto refuse = [&](const Error& why) { Do(action::AnswerCall{requested.request, why}); };
  const auto i = config_.IndexOf(requested.actuator);
  if (!i) return refuse(UnknownActuator(requested.actuator, config_));
  if (ConfigOf(*i).command.empty()) {
    return refuse(Refused<Refusal::kNoCommand>(requested.actuator));
  }
  const bool in_use = machine_.phase == Phase::kRunning || machine_.phase == Phase::kFailed;
  if (!in_use) return refuse(Refused<Refusal::kNotRestartable>(PhaseName(machine_.phase)));
  KnownActuator& known = Of(*i);
  if (RunsElsewhere(*i)) {
    const std::int32_t pid = known.report.pid;
    if (const std::string& host = ConfigOf(*i).host; !host.empty()) {
      return refuse(
          Refused<Refusal::kNoUnitOfHost>(requested.actuator, pid, host, pid, requested.actuator));
    }
    return refuse(
        Refused<Refusal::kOnAnotherHost>(requested.actuator, known.report.host.substr(0, 64), pid));
  }
  if (known.presence == Presence::kPresent && ProcessOf(*i) == 0) {
    return refuse(Refused<Refusal::kProcessUnknown>(requested.actuator));
  }
  known.restart.requests.push_back(requested.request);
  if (known.restart.requested) return;
  known.restart.requested = true;
  known.restart.count = 0;
  known.restart.given_up = false;
  known.down_requested = false;
  known.cause =
      RecordProcess(*i, kCodeOk, texts::RestartRequested(requested.actuator, requested.by));
  EndForRestart(*i);
}

// TearDown if it can be commanded, else SIGTERM, and SIGKILL when that does not help.
void Recovery::EndForRestart(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  const std::int32_t pid = ProcessOf(i);
  if (pid == 0 && known.process.launch ==
                      Launch::kUnderWay) {  // the start that is under way is the one requested
    known.restart.requested = false;
    known.presence = Presence::kStarting;
    known.set_up_by = now_ + config_.TimeFor(i, kSetUp);
    return;
  }
  if (pid == 0) return processes_.Recover(i);
  const bool can_be_commanded = known.presence == Presence::kPresent && !known.command &&
                                !known.report.busy() && !machine_.current &&
                                known.health != Health::kHung && ConfigOf(i).Lists(kTearDown) &&
                                known.state() != kTearDown;
  if (can_be_commanded) {
    return commands_.Issue(i, machine_.number + 1, State(kTearDown), config_.TimeFor(i, kTearDown),
                           true);
  }
  processes_.Terminate(i, pid, kEndTime);
  Do(action::SignalProcess{i, pid, false});
}

// Answers the restart requests when it is back, or when it will not come back.
void Recovery::AnswerRestarts(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  if (IsComing(i)) return;
  const bool ended = machine_.phase != Phase::kRunning && machine_.phase != Phase::kFailed;
  const bool may_go_on = known.due && !machine_.emergency.stop;
  const bool driven =
      ((Fits(i) || known.join_tried) && !may_go_on) || machine_.phase == Phase::kFailed;
  const bool there = known.presence == Presence::kPresent && !known.command && driven;
  if (!ended && !there && !known.fault) return;
  Result<> answer;
  if (known.fault) {
    answer = Error(*known.fault);
  } else if (!there) {
    answer = Refused<Refusal::kBeingTornDown>();
  }
  for (const RequestId request : std::exchange(known.restart.requests, {})) {
    Do(action::AnswerCall{request, answer});
  }
}

}  // namespace musher
