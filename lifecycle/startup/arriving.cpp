// An actuator publishes its status: this controller takes control of it, and it is present once it
// answers; or its SetUp has failed, or it was torn down before.

#include <algorithm>

#include "musher/lifecycle/decision.hpp"

namespace musher {

void Decision::On(const event::StatusSeen& seen) {
  ActuatorRecord& record = Of(seen.actuator);
  const ActuatorReport& report = seen.report;
  const bool same = report.incarnation == record.report.incarnation;
  if (same && (record.presence == Presence::kPresent || record.take_control_again)) {
    if (report.stamp < record.report.stamp) return;
    Accept(seen.actuator, report);
    // The latched status carries the outcome like the reply, and remains when the reply is lost.
    if (record.command && report.outcome_number == record.command->number) {
      EndCommand(seen.actuator, EvaluateReport(seen.actuator, *record.command));
    }
    return;
  }
  if (same && record.terminating != 0) return;  // its termination was decided
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
  if (report.incarnation == record.dead) return;
  if (!same && record.presence == Presence::kPresent) {
    if (IsImpostor(seen.actuator, report)) return;
    Lose(seen.actuator, "it was restarted", record.cause);
  }
  // Restarts by another party are counted as well.
  if (!same && record.report.incarnation != 0 && record.process == 0) ++record.restarts;
  if (!same) ForgetEnd(seen.actuator);
  Accept(seen.actuator, report);
  record.presence = Presence::kStarting;
  if (record.restart_at) CancelRestart(seen.actuator);
  // An actuator that publishes its status and never answers is given up like one that never starts.
  if (!record.set_up_by && !record.fault && !stopping) {
    record.set_up_by = now_ + config_.TimeFor(seen.actuator, kSetUp);
  }
  // Its services appear when it is set up; until then it cannot be queried.
  if (not_set_up) return;
  if (!stopping) TakeControl(seen.actuator);
}

// An actuator that was torn down before this controller started, and still runs: the start does not
// wait for it.
void Decision::FoundTornDown(std::size_t i, const ActuatorReport& report) {
  ActuatorRecord& record = Of(i);
  if (record.report.incarnation == 0 && record.elsewhere == report.host) {
    record.elsewhere.reset();  // another controller has torn it down
    Save(Stored::kRemoteActuators);
  }
  const bool same = report.incarnation == record.report.incarnation;
  const bool awaited = record.presence == Presence::kAbsent ||
                       (record.presence == Presence::kStarting && same && record.terminating == 0);
  if (!record.found_running || !record.set_up_by || !awaited || machine_.finishing ||
      report.incarnation == record.dead) {
    return;
  }
  record.report = report;
  record.set_up_by.reset();
  if (record.presence == Presence::kStarting) record.presence = Presence::kLost;
  Degrade(i, kCodeStateInvalid, kTornDownAlone, record.cause);
}

// A Musher actuator exits after a failed SetUp. A ROS 2 node keeps running unconfigured: it is
// present, and the next SelfCheck or switch up configures it again.
void Decision::SetUpFailed(std::size_t i, const ActuatorReport& report) {
  ActuatorRecord& record = Of(i);
  const bool same = report.incarnation == record.report.incarnation;
  const bool keeps_running = ConfigOf(i).protocol == Protocol::kRos2Lifecycle && same &&
                             record.presence == Presence::kStarting;
  if (same) record.report = report;
  if (keeps_running) {
    Attach(i);
    record.join_tried = true;  // no automatic retry
    record.due = false;
  }
  Degrade(i, report.outcome_code,
          "SetUp failed with " + CodeText(report.outcome_code) +
              (report.outcome_message.empty() ? "" : ": " + report.outcome_message),
          record.cause);
  if (keeps_running) FallBack(i);
}

// Takes control of an actuator that has published its status. The answer has its status and a fresh
// stamp, from which the actuator later computes the age of a command.
void Decision::TakeControl(std::size_t i) {
  ActuatorRecord& record = Of(i);
  const std::uint64_t seen = record.report.epoch;
  const bool ours = record.controlled == record.report.incarnation;
  if (seen >= kLastEpoch) {
    record.take_control_again.reset();
    return Degrade(i, kCodePermissionDenied,
                   "it reports epoch " + std::to_string(seen) + ", which is out of range");
  }
  if (seen > machine_.epoch || (seen == machine_.epoch && !ours)) {
    // Perhaps a running controller leads with it; then its heartbeat comes, and this one releases
    // control.
    if (!record.outbid_at)
      record.outbid_at = now_ + (config_.keys.empty() ? kRivalGrace : kSecuredRivalGrace);
    if (now_ < *record.outbid_at) {
      record.take_control_again = record.outbid_at;
      if (record.set_up_by)
        record.set_up_by = std::max(*record.set_up_by, *record.outbid_at + kTakeControlPeriod);
      return;
    }
    RaiseEpoch(seen + 1, i);
  }
  record.outbid_at.reset();
  record.controlled = record.report.incarnation;
  record.take_control_again = now_ + kTakeControlPeriod;
  Do(action::SendQuery{i, record.report.number, false});
}

// An earlier controller was here. The attached actuators get the new epoch at once.
void Decision::RaiseEpoch(std::uint64_t epoch, std::size_t because_of) {
  machine_.epoch = epoch;
  Save(Stored::kEpoch);
  Lower(std::nullopt);  // that controller may have changed the state of the machine
  RecordMachine(kCodeOk, "epoch " + std::to_string(epoch) + ": " + ConfigOf(because_of).name +
                             " was controlled by epoch " + std::to_string(epoch - 1));
  for (std::size_t other = 0; other < machine_.actuators.size(); ++other) {
    if (other == because_of || Of(other).presence != Presence::kPresent) continue;
    Do(action::SendQuery{other, 0, false});  // a waiting command there keeps waiting
  }
}

// The actuator has answered: it is present.
void Decision::Attach(std::size_t i) {
  ActuatorRecord& record = Of(i);
  record.take_control_again.reset();
  if (record.presence == Presence::kPresent) return;
  const bool late = machine_.phase == Phase::kRunning || machine_.phase == Phase::kFailed;
  record.presence = Presence::kPresent;
  record.set_up_by.reset();
  record.restart_at.reset();  // it was started by another party first
  record.fault.reset();
  record.tolerated.reset();
  const bool beyond = record.state() == kSelfCheck || config_.RankOf(record.state());
  record.checked = (beyond && record.state() != kError) || !ConfigOf(i).Lists(kSelfCheck);
  record.join_tried = false;
  record.held = record.report.apart;
  record.suspended = false;
  record.health = Health::kWell;
  record.due = late && record.checked && !record.held;
  if (record.report.busy()) record.free_by = now_ + config_.TimeFor(i, record.report.target);
  record.cause = RecordActuator(
      i, kCodeOk,
      ConfigOf(i).name + " is present in " + record.state() +
          (record.report.pid == 0 ? "" : " (pid " + std::to_string(record.report.pid) + ")"),
      record.cause);
  if (machine_.emergency_stop && record.report.emergency_stop == 0) {
    Do(action::PublishEmergencyStop{*machine_.emergency_stop,
                                    true});  // it may have missed the stop
  }
  if (record.state() == kTearDown && record.held)
    Degrade(i, kCodeStateInvalid, kTornDownAlone, record.cause);
  EvaluateArrival(i);
}

}  // namespace musher
