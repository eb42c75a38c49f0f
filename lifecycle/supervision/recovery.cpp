#include "musher/lifecycle/supervision/recovery.hpp"

#include <utility>

#include "musher/lifecycle/refusal.hpp"

namespace musher {
namespace {

void EndLaunch(ActuatorRecord& record) {
  if (record.process.launch == Launch::kUnderWay) record.process.launch = Launch::kNone;
}

}  // namespace

void Recovery::On(const event::HealthChanged& changed) {
  const ActuatorIndex i = changed.actuator;
  ActuatorRecord& record = Of(i);
  if (changed.incarnation != record.report.incarnation ||
      changed.incarnation == record.process.dead || machine_.phase == Phase::kStopping) {
    return;
  }
  if (changed.health == Health::kWell) return Recovered(i, changed.how);
  record.health = changed.health;
  const RecordText what = texts::Unhealthy(changed.health, changed.how);
  switch (changed.health) {
    case Health::kHung:
      return commands_.Hang(i, changed.silent, what);
    case Health::kCrashed:
    case Health::kPartitioned:
      if (record.presence == Presence::kPresent || record.presence == Presence::kStarting) {
        commands_.LoseConnection(i, what);
      }
      return;
    case Health::kStarved:
    case Health::kWell:
      RecordActuator(i, kCodeTimeout, texts::ActuatorStarved(ConfigOf(i).name, changed.how));
      return;
  }
}

void Recovery::Recovered(ActuatorIndex i, const std::string& how) {
  ActuatorRecord& record = Of(i);
  record.health = Health::kWell;
  record.cause =
      RecordActuator(i, kCodeOk, texts::ActuatorRecovered(ConfigOf(i).name, how), record.cause);
  if (!record.restart.requested)
    record.process.termination.reset();  // else it is terminated anyway
  if (record.presence == Presence::kLost) {
    record.presence = Presence::kStarting;
    return control_.Take(i);
  }
  if (record.presence == Presence::kPresent && record.fault && record.checked && !record.held) {
    record.due = true;
  }
}

void Recovery::On(const event::BacktraceTaken& taken) {
  ActuatorRecord& record = Of(taken.actuator);
  const auto& termination = record.process.termination;  // none: it has recovered, or has exited
  if (!termination || termination->pid != taken.pid || termination->killed) return;
  action::Record backtrace;
  backtrace.kind = "process";
  backtrace.actuator = taken.actuator;
  const RecordText text = texts::BacktraceTaken(ConfigOf(taken.actuator).name);
  backtrace.message = text.message;
  backtrace.event = text.event;
  backtrace.arguments = text.arguments;
  backtrace.cause = record.cause;
  backtrace.data = taken.text;
  Record(backtrace);
  processes_.Kill(taken.actuator);
}

// Its exit was not seen, or the kernel delays it. If it still runs, its successor will report that.
void Recovery::AssumeExited(ActuatorIndex i) {
  ActuatorRecord& record = Of(i);
  const std::int32_t pid = record.process.termination->pid;
  RecordProcess(i, kCodeTimeout, texts::ProcessExitAssumed(pid));
  if (record.process.pid == pid) record.process.pid = 0;
  record.process.dead = record.report.incarnation;
  if (record.presence == Presence::kPresent) commands_.Lose(i, texts::Killed());
  processes_.Recover(i);
}

void Recovery::CheckDeadlines() {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    ActuatorRecord& record = Of(i);
    if (auto& termination = record.process.termination) {
      if (termination->terminate_at && *termination->terminate_at <= now_) {
        termination->terminate_at.reset();
        Do(action::SignalProcess{i, termination->pid, false});
      }
      if (termination->kill_at <= now_) termination->killed ? AssumeExited(i) : processes_.Kill(i);
    }
    if (record.restart.reset_at && *record.restart.reset_at <= now_) {
      record.restart.reset_at.reset();
      record.restart.count = 0;
      if (std::exchange(record.restart.given_up, false)) record.due = record.checked;
    }
    if (record.restart.at && *record.restart.at <= now_) processes_.StartAgain(i);
    if (ConfigOf(i).restart.finalized) RestartFinalized(i);
    if (!record.restart.requests.empty()) AnswerRestarts(i);
  }
}

// Another client has finalized the ROS 2 node: its process runs on, and only a new one can be
// configured. At most as often in a row as its process is restarted.
void Recovery::RestartFinalized(ActuatorIndex i) {
  ActuatorRecord& record = Of(i);
  const bool running = machine_.phase == Phase::kRunning || machine_.phase == Phase::kFailed;
  const bool finalized = record.presence == Presence::kPresent && record.state() == kTearDown &&
                         !record.held && !record.report.detached && !record.command;
  const bool ending = record.restart.requested || record.process.termination.has_value();
  const RestartConfig& restart = ConfigOf(i).restart;
  if (!running || !finalized || ending || machine_.current || ProcessOf(i) == 0 ||
      record.restart.count >= restart.limit) {
    return;
  }
  ++record.restart.count;
  record.restart.requested = true;
  record.cause = RecordProcess(i, kCodeOk,
                               texts::RestartScheduled(ConfigOf(i).name, Duration::zero(),
                                                       record.restart.count, restart.limit),
                               record.cause);
  EndForRestart(i);
}

void Recovery::On(const event::ProcessStarted& started) {
  ActuatorRecord& record = Of(started.actuator);
  record.process.pid = started.pid;
  EndLaunch(record);
  record.cause = RecordProcess(started.actuator, kCodeOk,
                               texts::ProcessStarted(ConfigOf(started.actuator).name, started.pid),
                               record.cause);
  // The machine was torn down while the process was starting.
  const bool stopped = machine_.phase == Phase::kStopped;
  if (!stopped && machine_.phase != Phase::kStopping) return;
  Do(action::SignalProcess{started.actuator, started.pid,
                           stopped || machine_.stopping->sent == Stopping::Signal::kKill});
}

// Possibly after its process was forked and could not execute the program.
void Recovery::On(const event::ProcessNotStarted& failed) {
  Of(failed.actuator).process.pid = 0;
  EndLaunch(Of(failed.actuator));
  // Another party has started it.
  const bool announced = Of(failed.actuator).control.again.has_value();
  if (Of(failed.actuator).presence == Presence::kPresent || announced) return;
  Of(failed.actuator).presence = Presence::kAbsent;
  Degrade(failed.actuator, kCodeFailed, texts::ProcessNotStarted(failed.why),
          Of(failed.actuator).cause);
  processes_.Recover(failed.actuator);
}

void Recovery::On(const event::ProcessEnded& ended) {
  ActuatorRecord& record = Of(ended.actuator);
  if (record.process.pid != ended.pid) return;
  record.process.pid = 0;
  if (record.report.pid == ended.pid) record.process.dead = record.report.incarnation;
  record.cause =
      RecordProcess(ended.actuator, ended.clean ? kCodeOk : kCodeFailed,
                    texts::ProcessExited(ConfigOf(ended.actuator).name, ended.pid, ended.how),
                    record.fault ? record.cause : 0);
  if (AnotherProcessIsPresent(ended.actuator, ended.pid)) return;
  // The exit status of a process that we have not started is unknown.
  if (ended.clean || record.process.launch == Launch::kFoundRunning)
    commands_.AssumeTornDown(ended.actuator);
  // A clean exit that was not requested is a loss, but not a crash.
  if (record.health != Health::kHung && !ended.clean) record.health = Health::kCrashed;
  const bool in_set_up = record.presence == Presence::kStarting;
  const RecordText why = processes_.IsFinal(ended.actuator, ended)
                             ? processes_.WhyFinal(ended)
                             : texts::Exited(ended.pid, ended.how, ended.clean, in_set_up);
  if (in_set_up || record.presence == Presence::kPresent) {
    const bool final = processes_.IsFinal(ended.actuator, ended);
    commands_.Lose(ended.actuator, why, record.cause, final ? kCodeFailed : kCodeNetError);
  } else if (WasDisconnected(ended.actuator)) {
    // The lost connection was the first sign of the exit.
    Degrade(ended.actuator, record.fault->code, why, record.cause);
  }
  processes_.Recover(ended.actuator, ended);
}

// Whether a lost connection is all that is known about its loss.
bool Recovery::WasDisconnected(ActuatorIndex i) const {
  const ActuatorRecord& record = Of(i);
  return record.presence == Presence::kLost && record.fault &&
         record.fault->event == EventName::kConnectionLost;
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
  ActuatorRecord& record = Of(*i);
  if (RunsElsewhere(*i)) {
    return refuse(Refused<Refusal::kOnAnotherHost>(
        requested.actuator, record.report.host.substr(0, 64), record.report.pid));
  }
  if (record.presence == Presence::kPresent && ProcessOf(*i) == 0) {
    return refuse(Refused<Refusal::kProcessUnknown>(requested.actuator));
  }
  record.restart.requests.push_back(requested.request);
  if (record.restart.requested) return;
  record.restart.requested = true;
  record.restart.count = 0;
  record.restart.given_up = false;
  record.cause = RecordProcess(*i, kCodeOk, texts::RestartRequested(requested.actuator));
  EndForRestart(*i);
}

// TearDown if it can be commanded, else SIGTERM, and SIGKILL when that does not help.
void Recovery::EndForRestart(ActuatorIndex i) {
  ActuatorRecord& record = Of(i);
  const std::int32_t pid = ProcessOf(i);
  if (pid == 0 && record.process.launch ==
                      Launch::kUnderWay) {  // the start that is under way is the one requested
    record.restart.requested = false;
    record.presence = Presence::kStarting;
    record.set_up_by = now_ + config_.TimeFor(i, kSetUp);
    return;
  }
  if (pid == 0) return processes_.Recover(i);
  const bool can_be_commanded = record.presence == Presence::kPresent && !record.command &&
                                !record.report.busy() && !machine_.current &&
                                record.health != Health::kHung && ConfigOf(i).Lists(kTearDown) &&
                                record.state() != kTearDown;
  if (can_be_commanded) {
    return commands_.Issue(i, machine_.number + 1, State(kTearDown), config_.TimeFor(i, kTearDown),
                           true);
  }
  processes_.Terminate(i, pid, kEndTime);
  Do(action::SignalProcess{i, pid, false});
}

// Answers the restart requests when it is back, or when it will not come back.
void Recovery::AnswerRestarts(ActuatorIndex i) {
  ActuatorRecord& record = Of(i);
  if (IsComing(i)) return;
  const bool ended = machine_.phase != Phase::kRunning && machine_.phase != Phase::kFailed;
  const bool may_go_on = record.due && !machine_.emergency.stop;
  const bool driven =
      ((Fits(i) || record.join_tried) && !may_go_on) || machine_.phase == Phase::kFailed;
  const bool there = record.presence == Presence::kPresent && !record.command && driven;
  if (!ended && !there && !record.fault) return;
  Result<> answer;
  if (record.fault) {
    answer = Error(*record.fault);
  } else if (!there) {
    answer = Refused<Refusal::kBeingTornDown>();
  }
  for (const RequestId request : std::exchange(record.restart.requests, {})) {
    Do(action::AnswerCall{request, answer});
  }
}

}  // namespace musher
