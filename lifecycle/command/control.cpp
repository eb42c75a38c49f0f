#include "musher/lifecycle/command/control.hpp"

#include <algorithm>

namespace musher {

void Control::Take(ActuatorIndex i) {
  ActuatorRecord& record = Of(i);
  const Epoch seen = record.report.epoch;
  const bool ours = record.control.incarnation == record.report.incarnation;
  if (seen >= kLastEpoch) {
    record.control.again.reset();
    return Degrade(i, kCodePermissionDenied, texts::EpochOutOfRange(seen));
  }
  if (seen > machine_.epoch || (seen == machine_.epoch && !ours)) {
    // Perhaps a running controller leads with it; then its heartbeat comes, and this one releases
    // control.
    if (!record.control.outbid_at)
      record.control.outbid_at = now_ + (config_.keys.empty() ? kRivalGrace : kSecuredRivalGrace);
    if (now_ < *record.control.outbid_at) {
      record.control.again = record.control.outbid_at;
      if (record.set_up_by)
        record.set_up_by =
            std::max(*record.set_up_by, *record.control.outbid_at + kTakeControlPeriod);
      return;
    }
    RaiseEpoch(seen + 1, i);
  }
  record.control.outbid_at.reset();
  record.control.incarnation = record.report.incarnation;
  record.control.again = now_ + kTakeControlPeriod;
  Do(action::SendQuery{i, {machine_.epoch, record.report.number, false}});
}

// An earlier controller was here. The attached actuators get the new epoch at once.
void Control::RaiseEpoch(Epoch epoch, ActuatorIndex because_of) {
  machine_.epoch = epoch;
  saving_.Save(Stored::kEpoch);
  memory_.Lower(std::nullopt);  // that controller may have changed the state of the machine
  RecordMachine(kCodeOk, texts::EpochRaised(epoch, ConfigOf(because_of).name));
  for (const ActuatorIndex other : machine_.actuators.Indices()) {
    if (other == because_of || Of(other).presence != Presence::kPresent) continue;
    Do(action::SendQuery{other,
                         {machine_.epoch, 0, false}});  // a waiting command there keeps waiting
  }
}

void Control::Attach(ActuatorIndex i) {
  ActuatorRecord& record = Of(i);
  record.control.again.reset();
  if (record.presence == Presence::kPresent) return;
  const bool late = machine_.start_up.set_up && machine_.phase != Phase::kStopping &&
                    machine_.phase != Phase::kStopped;
  record.presence = Presence::kPresent;
  record.set_up_by.reset();
  record.restart.at.reset();  // it was started by another party first
  record.fault.reset();
  record.tolerated.reset();
  const bool beyond = record.state() == kSelfCheck || config_.RankOf(record.state());
  record.checked = (beyond && record.state() != kError) || !ConfigOf(i).Lists(kSelfCheck);
  record.join_tried = false;
  record.failed_checks = {};
  record.held = record.report.detached;
  record.suspended = false;
  record.health = Health::kWell;
  record.due = late && record.checked && !record.held;
  if (record.report.busy()) record.free_by = now_ + config_.TimeFor(i, record.report.target);
  record.cause = RecordActuator(
      i, kCodeOk, texts::ActuatorPresent(ConfigOf(i).name, record.state(), record.report.pid),
      record.cause);
  if (machine_.emergency.stop && record.report.emergency_stop == 0) {
    Do(action::PublishEmergencyStop{*machine_.emergency.stop,
                                    true});  // it may have missed the stop
  }
  if (record.state() == kTearDown && record.held)
    Degrade(i, kCodeStateInvalid, texts::TornDownAlone(), record.cause);
  processes_.EvaluateArrival(i);
}

}  // namespace musher
