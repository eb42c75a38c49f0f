#include "musher/lifecycle/switch/arrivals.hpp"

#include <utility>

namespace musher {

void Arrivals::On(const event::StatusSeen& seen) {
  ActuatorRecord& record = Of(seen.actuator);
  const ActuatorReport& report = seen.report;
  const bool same = report.incarnation == record.report.incarnation;
  if (same && (record.presence == Presence::kPresent || record.control.again)) {
    if (report.stamp < record.report.stamp) return;
    commands_.Accept(seen.actuator, report);
    // The latched status carries the outcome like the reply, and remains when the reply is lost.
    if (record.command && report.outcome_number == record.command->number) {
      commands_.End(seen.actuator, commands_.EvaluateReport(seen.actuator, *record.command));
    }
    return;
  }
  if (same && record.process.termination) return;  // its termination was decided
  // The status of an exited process can arrive after the status of its successor.
  // Incarnations are compared within a boot of a host only, which an empty host does not name.
  const bool of_the_past = !report.host.empty() && report.host == record.report.host &&
                           report.incarnation < record.report.incarnation;
  if (of_the_past || machine_.phase == Phase::kIdle) return;
  if (report.state == kTearDown) return FoundTornDown(seen.actuator, report);
  const bool not_set_up = report.state == config_.default_state;
  const bool stopping = machine_.phase == Phase::kStopping || machine_.phase == Phase::kStopped;
  if (not_set_up && !report.busy() && report.outcome_code != kCodeOk) {
    if (!stopping) SetUpFailed(seen.actuator, report);
    return;
  }
  if (report.incarnation == record.process.dead) return;
  if (!same && record.presence == Presence::kPresent) {
    if (IsImpostor(seen.actuator, report)) return;
    commands_.Lose(seen.actuator, texts::Replaced(), record.cause);
  }
  // Restarts by another party are counted as well.
  if (!same && record.report.incarnation != 0 && record.process.pid == 0) ++record.restart.count;
  if (!same) {
    processes_.ForgetEnd(seen.actuator);
    record.control.rival_until.reset();
  }
  commands_.Accept(seen.actuator, report);
  record.presence = Presence::kStarting;
  if (record.restart.at) processes_.CancelRestart(seen.actuator);
  // An actuator that publishes its status and never answers is given up like one that never starts.
  if (!record.set_up_by && !record.fault && !stopping) {
    record.set_up_by = now_ + config_.TimeFor(seen.actuator, kSetUp);
  }
  // Its services appear when it is set up; until then it cannot be queried.
  if (not_set_up) return;
  if (!stopping) control_.Take(seen.actuator);
}

// An actuator that was torn down before this controller started, and still runs: the start does not
// wait for it.
void Arrivals::FoundTornDown(ActuatorIndex i, const ActuatorReport& report) {
  ActuatorRecord& record = Of(i);
  if (record.report.incarnation == 0 && record.elsewhere == report.host) {
    record.elsewhere.reset();  // another controller has torn it down
    saver_.Save(Stored::kRemoteActuators);
  }
  const bool same = report.incarnation == record.report.incarnation;
  const bool awaited =
      record.presence == Presence::kAbsent ||
      (record.presence == Presence::kStarting && same && !record.process.termination);
  if (record.process.launch != Launch::kFoundRunning || !record.set_up_by || !awaited ||
      machine_.start_up.finishing || report.incarnation == record.process.dead) {
    return;
  }
  record.report = report;
  record.set_up_by.reset();
  if (record.presence == Presence::kStarting) record.presence = Presence::kLost;
  Degrade(i, kCodeStateInvalid, texts::TornDownAlone(), record.cause);
}

// A Musher actuator exits after a failed SetUp. A ROS 2 node keeps running unconfigured: it is
// present, and the next SelfCheck or switch up configures it again.
void Arrivals::SetUpFailed(ActuatorIndex i, const ActuatorReport& report) {
  ActuatorRecord& record = Of(i);
  const bool same = report.incarnation == record.report.incarnation;
  const bool keeps_running = ConfigOf(i).protocol == Protocol::kRos2Lifecycle && same &&
                             record.presence == Presence::kStarting;
  if (same) record.report = report;
  if (keeps_running) {
    control_.Attach(i);
    record.join_tried = true;  // no automatic retry
    record.due = false;
  }
  Degrade(i, report.outcome_code, texts::SetUpFailed(report.outcome_code, report.outcome_message),
          record.cause);
  if (keeps_running) FallBack(i);
}

// A process on another host publishes as this actuator while the known process still answers.
bool Arrivals::IsImpostor(ActuatorIndex i, const ActuatorReport& report) {
  ActuatorRecord& record = Of(i);
  if (report.host == record.report.host) return false;
  const bool known = record.other && record.other->host == report.host &&
                     record.other->incarnation == report.incarnation;
  record.other = report;
  if (known) return true;
  RecordActuator(i, kCodePermissionDenied,
                 texts::DuplicateActuator(ConfigOf(i).name, report.pid, report.host.substr(0, 64),
                                          record.report.pid));
  return true;
}

void Arrivals::TakeUpOthers() {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    ActuatorRecord& record = Of(i);
    if (!record.other || record.presence == Presence::kPresent) continue;
    const ActuatorReport other = *std::exchange(record.other, std::nullopt);
    if (record.presence == Presence::kLost) On(event::StatusSeen{i, other});
  }
}

void Arrivals::On(const event::Replied& replied) {
  ActuatorRecord& record = Of(replied.actuator);
  if (replied.report.incarnation != record.report.incarnation) return;
  // A delayed reply of a process whose exit is known already.
  if (record.process.dead == replied.report.incarnation) return;
  if (replied.report.stamp >= record.report.stamp)
    commands_.Accept(replied.actuator, replied.report);
  // A lost one publishes its status again when it can be reached.
  const bool announced =
      record.presence == Presence::kPresent || record.presence == Presence::kStarting;
  const bool denied =
      announced && replied.verdict == Verdict::kRefused && replied.code == kCodePermissionDenied;
  if (replied.query && denied && replied.report.epoch > machine_.epoch)
    return control_.Take(replied.actuator);
  if (denied && replied.report.epoch == machine_.epoch) {
    // Another controller with the same epoch has taken it, unnoticed: on the other side of a
    // partition.
    record.control.incarnation = 0;
    control_.Take(replied.actuator, true);
  }
  if (replied.query && denied && record.control.again) {
    record.control.again = now_ + kIntroductionPeriod;  // our heartbeat has not arrived yet
  }
  if (replied.query && replied.verdict == Verdict::kDone && record.control.again) {
    control_.Attach(replied.actuator);
  }
  if (!record.command || record.command->number != replied.number) return;
  if (replied.query && record.command->queries == 0)
    return;  // it answers control_.Take(), not the query
  if (replied.query)
    return commands_.End(replied.actuator,
                         commands_.EvaluateReport(replied.actuator, *record.command));
  switch (replied.verdict) {
    case Verdict::kDone:
      return commands_.End(replied.actuator,
                           commands_.DoneUnlessContradicted(replied.actuator, replied.message));
    case Verdict::kRefused:
      if (replied.code == kCodeTimeout && commands_.SendAgain(replied.actuator)) return;
      return commands_.End(
          replied.actuator,
          {record.command->queries > 0 ? ActuatorOutcome::kOverdue : ActuatorOutcome::kRefused,
           replied.code, texts::Reported(ActuatorOutcome::kRefused, replied.message), false});
    case Verdict::kFailed:
      return commands_.End(replied.actuator,
                           {ActuatorOutcome::kFailed, replied.code,
                            texts::Reported(ActuatorOutcome::kFailed, replied.message), true});
  }
}

void Arrivals::On(const event::Vanished& vanished) {
  ActuatorRecord& record = Of(vanished.actuator);
  if (record.other && record.other->incarnation == vanished.incarnation) record.other.reset();
  if (record.report.incarnation != vanished.incarnation) return;
  if (record.process.dead == vanished.incarnation) return;  // its successor may be starting already
  const bool was_there =
      record.presence == Presence::kPresent || record.presence == Presence::kStarting;
  if (!vanished.for_good) {
    if (was_there) {
      commands_.LoseConnection(vanished.actuator, texts::Disconnected(vanished.how));
    }
    return;
  }
  record.process.dead = vanished.incarnation;
  commands_.AssumeTornDown(vanished.actuator);
  if (record.health != Health::kHung) record.health = Health::kCrashed;
  if (was_there) commands_.Lose(vanished.actuator, texts::Crashed(vanished.how));
  if (record.restart.at) return;  // our process has exited before
  if (record.restart.given_up) return FallBack(vanished.actuator);
  if (record.process.pid != 0)
    return processes_.Terminate(vanished.actuator, record.process.pid, kEndTime);
  processes_.Recover(vanished.actuator);
}

void Arrivals::CheckDeadlines() {
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    ActuatorRecord& record = Of(i);
    if (record.command && record.command->deadline <= now_) commands_.QueryOrLose(i);
    if (record.control.again && *record.control.again <= now_) control_.Take(i);
    if (record.free_by && *record.free_by <= now_) EvaluateFoundBusy(i);
  }
}

// A callback that it was found busy with, or that was superseded, has its deadline, too.
void Arrivals::EvaluateFoundBusy(ActuatorIndex i) {
  ActuatorRecord& record = Of(i);
  record.free_by.reset();
  if (!record.report.busy() || record.command || record.presence != Presence::kPresent) return;
  const State& target = record.report.target;
  Degrade(i, kCodeTimeout, texts::FoundBusy(target, config_.TimeFor(i, target)));
  Do(action::SendQuery{i, {machine_.epoch, record.report.number, true}});
  FallBack(i);
}

}  // namespace musher
