#include "musher/lifecycle/switch/arrivals.hpp"

#include <utility>

namespace musher {
namespace {

bool IsOfOneProcess(const ActuatorReport& one, const ActuatorReport& other) {
  return one.host == other.host && one.incarnation == other.incarnation;
}

bool IsOfTaken(const KnownActuator& known, const ActuatorReport& report) {
  const auto& taken = known.process.taken;
  return taken && taken->pid == report.pid && taken->host == report.host;
}

// The known process hangs, or is to restart, and is ended: one on another host waits for that. Else
// its end would be forgotten, and the frozen process stay in the state that it is in.
bool EndsSoon(const KnownActuator& known) {
  const auto& termination = known.process.termination;
  const bool was_met = known.report.incarnation != 0;
  return was_met && termination && !termination->for_silence && !termination->overdue;
}

}  // namespace

void Arrivals::On(const event::StatusSeen& seen) {
  KnownActuator& known = Of(seen.actuator);
  const ActuatorReport& report = seen.report;
  const bool same = report.incarnation == known.report.incarnation;
  if (same && (known.presence == Presence::kPresent || known.control.again)) {
    if (report.stamp < known.report.stamp) return;
    known.writer_lost = false;
    commands_.Accept(seen.actuator, report);
    // The latched status carries the outcome like the reply, and remains when the reply is lost.
    if (known.command && report.outcome_number == known.command->number) {
      commands_.End(seen.actuator, commands_.EvaluateReport(seen.actuator, *known.command));
    }
    return;
  }
  if (same && known.process.termination) return;  // its termination was decided
  // The status of an exited process can arrive after the status of its successor.
  // Incarnations are compared within a boot of a host only, which an empty host does not name.
  const bool of_the_past = !report.host.empty() && report.host == known.report.host &&
                           report.incarnation < known.report.incarnation;
  if (of_the_past || machine_.phase == Phase::kIdle) return;
  const bool not_set_up = report.state == config_.default_state;
  const bool set_up_failed = not_set_up && !report.busy() && report.outcome_code != kCodeOk;
  const bool over = report.state == kTearDown || set_up_failed;
  const bool second = known.other && IsOfOneProcess(*known.other, report);
  if (over && second) known.other.reset();
  if (report.state == kTearDown) return FoundTornDown(seen.actuator, report);
  const bool stopping = machine_.phase == Phase::kStopping || machine_.phase == Phase::kStopped;
  if (set_up_failed) {
    if (!stopping && !second) SetUpFailed(seen.actuator, report);
    return;
  }
  if (report.incarnation == known.process.dead) return;
  // Its process has exited before this status arrived, and is restarted.
  if (known.restart.at && IsOfEnded(seen.actuator, report)) {
    return stops_.CompareLatched(report, seen.actuator);
  }
  if (!same && known.presence == Presence::kPresent) {
    if (IsImpostor(seen.actuator, report)) return;
    commands_.Lose(seen.actuator, texts::Replaced(), known.cause);
  }
  if (!same && EndsSoon(known) && IsImpostor(seen.actuator, report)) return;
  if (second) known.other.reset();  // it is the one in use from now on
  if (!same && MayRunBeside(seen.actuator, report)) {
    NoteOther(seen.actuator, ActuatorReport(known.report), report.pid);
  }
  // Restarts by another party are counted as well.
  if (!same && known.report.incarnation != 0 && known.process.pid == 0) ++known.restart.count;
  if (!same) {
    known.met = false;
    known.found_below = false;
    processes_.ForgetEnd(seen.actuator);
    known.control.rival_until.reset();
  }
  known.writer_lost = false;
  if (IsOfTaken(known, report)) known.process.taken.reset();  // it is this machine's again
  commands_.Accept(seen.actuator, report);
  known.presence = Presence::kStarting;
  if (!same) known.exit_by.reset();
  if (known.restart.at) processes_.CancelRestart(seen.actuator);
  // An actuator that publishes its status but never answers is given up, as if it never started.
  if (!known.set_up_by && !known.fault && !stopping) {
    known.set_up_by = now_ + config_.TimeFor(seen.actuator, kSetUp);
  }
  // Its services appear when it is set up; until then it cannot be queried.
  if (not_set_up) return;
  const bool awaited = machine_.stopping && machine_.stopping->announced_by;
  if (!stopping || awaited) control_.Take(seen.actuator);
}

// An actuator that was torn down before this controller started, and still runs: the start does not
// wait for it.
void Arrivals::FoundTornDown(ActuatorIndex i, const ActuatorReport& report) {
  KnownActuator& known = Of(i);
  if (known.report.incarnation == 0 && known.elsewhere == report.host) {
    known.elsewhere.reset();  // another controller has torn it down
    saver_.Save(Stored::kRemoteActuators);
  }
  const bool same = report.incarnation == known.report.incarnation;
  if (same) known.lost_in = {};  // only its connection was lost
  const bool awaited =
      known.presence == Presence::kAbsent ||
      (known.presence == Presence::kStarting && same && !known.process.termination);
  if (known.process.launch != Launch::kFoundRunning || !known.set_up_by || !awaited ||
      machine_.start_up.finishing || report.incarnation == known.process.dead) {
    return;
  }
  known.report = report;
  known.set_up_by.reset();
  if (known.presence == Presence::kStarting) known.presence = Presence::kLost;
  Degrade(i, kCodeStateInvalid, texts::TornDownAlone(), known.cause);
}

// A Musher actuator exits after a failed SetUp. A ROS 2 node keeps running unconfigured: it is
// present, and the next SelfCheck or switch up configures it again. A second process on another
// host says nothing about the one in use, which goes on; on the same host it is the successor.
void Arrivals::SetUpFailed(ActuatorIndex i, const ActuatorReport& report) {
  KnownActuator& known = Of(i);
  const bool same = report.incarnation == known.report.incarnation;
  const bool elsewhere = report.host != known.report.host;
  const bool runs = known.report.incarnation != known.process.dead;
  const bool in_use = runs && (known.presence == Presence::kPresent || known.control.again);
  if (!same && elsewhere && in_use) return RecordDuplicate(i, report, known.report.pid);
  const bool keeps_running = ConfigOf(i).protocol == Protocol::kRos2Lifecycle && same &&
                             known.presence == Presence::kStarting;
  if (same) known.report = report;
  if (keeps_running) {
    control_.Attach(i);
    known.join_tried = true;  // no automatic retry
    known.due = false;
  }
  Degrade(i, report.outcome_code, texts::SetUpFailed(report.outcome_code, report.outcome_message),
          known.cause);
  if (keeps_running) FallBack(i);
}

// Whether the process in use before `report` may run on, on another host. Two processes may publish
// in turn before one of them is attached. A process that does not answer may only be out of reach
// for a moment: as long as its writer is not lost, its latched status does not come again.
bool Arrivals::MayRunBeside(ActuatorIndex i, const ActuatorReport& report) const {
  const KnownActuator& known = Of(i);
  const ActuatorReport& before = known.report;
  if (before.host.empty() || before.host == report.host) return false;
  const bool attaching = known.presence == Presence::kStarting && known.control.again;
  const bool out_of_reach = known.presence == Presence::kLost && !known.writer_lost &&
                            before.incarnation != 0 && before.incarnation != known.process.dead &&
                            before.state != kTearDown;
  return attaching || out_of_reach;
}

// A process on another host publishes as this actuator while the known process still answers.
bool Arrivals::IsImpostor(ActuatorIndex i, const ActuatorReport& report) {
  const ActuatorReport& used = Of(i).report;
  if (report.host == used.host) return false;
  NoteOther(i, report, used.pid);
  return true;
}

// The other process is used once the process in use is lost.
void Arrivals::NoteOther(ActuatorIndex i, const ActuatorReport& other, std::int32_t used) {
  KnownActuator& known = Of(i);
  const bool repeated = known.other && IsOfOneProcess(*known.other, other);
  if (repeated && other.stamp < known.other->stamp) return;  // a newer one was faster
  known.other = other;
  stops_.CompareLatched(other, i);
  if (!repeated) RecordDuplicate(i, other, used);
}

void Arrivals::RecordDuplicate(ActuatorIndex i, const ActuatorReport& other, std::int32_t used) {
  RecordActuator(
      i, kCodePermissionDenied,
      texts::DuplicateActuator(ConfigOf(i).name, other.pid, other.host.substr(0, 64), used));
}

void Arrivals::TakeUpOthers() {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    KnownActuator& known = Of(i);
    if (!known.other || known.presence != Presence::kLost || known.control.again) continue;
    if (EndsSoon(known)) continue;
    On(event::StatusSeen{i, *std::exchange(known.other, std::nullopt)});
  }
}

void Arrivals::On(const event::Replied& replied) {
  KnownActuator& known = Of(replied.actuator);
  if (replied.report.incarnation != known.report.incarnation) return;
  // A delayed reply of a process whose exit is known already.
  if (known.process.dead == replied.report.incarnation) return;
  // A query from before the loss fences fewer commands than the query that takes control again.
  const bool fences = replied.report.number >= known.report.number;
  if (replied.report.stamp >= known.report.stamp)
    commands_.Accept(replied.actuator, replied.report);
  // A lost actuator publishes its status again when it can be reached.
  const bool announced =
      known.presence == Presence::kPresent || known.presence == Presence::kStarting;
  const bool denied =
      announced && replied.verdict == Verdict::kRefused && replied.code == kCodePermissionDenied;
  if (replied.query && denied && replied.report.epoch > machine_.epoch)
    return control_.Take(replied.actuator);
  if (denied && replied.report.epoch == machine_.epoch) {
    // Another controller with the same epoch has taken the actuator unnoticed, on the other side of
    // a partition.
    known.control.incarnation = 0;
    control_.Take(replied.actuator, true);
  }
  if (replied.query && denied && known.control.again) {
    known.control.again = now_ + kIntroductionPeriod;  // our heartbeat has not arrived yet
  }
  if (replied.query && replied.verdict == Verdict::kDone && known.control.again && fences) {
    control_.Attach(replied.actuator);
  }
  if (!known.command || known.command->number != replied.number) return;
  if (replied.query && known.command->queries == 0)
    return;  // it answers control_.Take(), not the query
  if (replied.query)
    return commands_.End(replied.actuator,
                         commands_.EvaluateReport(replied.actuator, *known.command));
  switch (replied.verdict) {
    case Verdict::kDone:
      return commands_.End(replied.actuator,
                           commands_.DoneUnlessContradicted(replied.actuator, replied.message));
    case Verdict::kRefused:
      if (replied.code == kCodeTimeout && commands_.SendAgain(replied.actuator)) return;
      return commands_.End(
          replied.actuator,
          {known.command->queries > 0 ? ActuatorOutcome::kOverdue : ActuatorOutcome::kRefused,
           replied.code, texts::Reported(ActuatorOutcome::kRefused, replied.message), false});
    case Verdict::kFailed:
      return commands_.End(replied.actuator,
                           {ActuatorOutcome::kFailed, replied.code,
                            texts::Reported(ActuatorOutcome::kFailed, replied.message), true});
  }
}

void Arrivals::On(const event::Vanished& vanished) {
  KnownActuator& known = Of(vanished.actuator);
  if (known.other && known.other->incarnation == vanished.incarnation) known.other.reset();
  if (vanished.taken) return LoseToOther(vanished);
  if (known.report.incarnation != vanished.incarnation) return;
  known.writer_lost = true;
  if (known.process.dead == vanished.incarnation) return;  // its successor may be starting already
  const bool was_there =
      known.presence == Presence::kPresent || known.presence == Presence::kStarting;
  if (!vanished.for_good) {
    if (was_there) commands_.LoseConnection(vanished.actuator, texts::Disconnected(vanished.how));
    return;
  }
  known.process.dead = vanished.incarnation;
  known.exit_by.reset();
  if (vanished.clean) commands_.AssumeTornDown(vanished.actuator);
  if (known.health != Health::kHung) known.health = Health::kCrashed;
  if (was_there) commands_.Lose(vanished.actuator, texts::Crashed(vanished.how));
  commands_.StayDown(vanished.actuator);
  if (known.restart.at) return;  // our process has exited before
  if (known.restart.given_up) return FallBack(vanished.actuator);
  if (known.process.pid != 0)
    return processes_.Terminate(vanished.actuator, known.process.pid, kEndTime);
  processes_.Recover(vanished.actuator);
}

// The process runs on and is well: no exit and no hang will be seen of it. It may have been taken
// before a status of it arrived here, as at the start of this controller.
void Arrivals::LoseToOther(const event::Vanished& lost) {
  const ActuatorIndex i = lost.actuator;
  KnownActuator& known = Of(i);
  const bool is_known = IsTaken(i);
  if (lost.pid != 0) known.process.taken = TakenProcess{lost.pid, lost.host, lost.how};
  const bool reported = known.report.incarnation == lost.incarnation;
  if (reported) known.writer_lost = true;
  const bool in_use = reported || (IsTaken(i) && !AnotherProcessIsPresent(i, lost.pid));
  if (!in_use || known.process.dead == lost.incarnation) return;
  if (IsTaken(i)) processes_.ForgetEnd(i);  // as for a restart
  known.exit_by.reset();
  const bool was_there =
      known.presence == Presence::kPresent || known.presence == Presence::kStarting;
  if (was_there) {
    commands_.LoseConnection(i, texts::Disconnected(lost.how));
  } else if (is_known) {
    return;
  }
  const bool stops = machine_.phase == Phase::kStopping || machine_.phase == Phase::kStopped;
  if (!stops) Degrade(i, kCodeNetError, texts::Disconnected(lost.how), known.cause);
  // Where nothing restarts it, the loss of its connection has led the machine down already.
  if (was_there || MayRestart(i)) FallBack(i);
}

void Arrivals::CheckDeadlines() {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    KnownActuator& known = Of(i);
    if (known.command && known.command->deadline <= now_) commands_.QueryOrLose(i);
    if (known.control.again && *known.control.again <= now_) control_.Take(i);
    if (known.free_by && *known.free_by <= now_) EvaluateFoundBusy(i);
  }
}

// A callback that it was found busy with, or that was superseded, has its deadline, too.
void Arrivals::EvaluateFoundBusy(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  known.free_by.reset();
  if (!known.report.busy() || known.command || known.presence != Presence::kPresent) return;
  const State& target = known.report.target;
  Degrade(i, kCodeTimeout, texts::FoundBusy(target, config_.TimeFor(i, target)));
  Do(action::SendQuery{i, {machine_.epoch, known.report.number, true}});
  FallBack(i);
}

}  // namespace musher
