#include "musher/lifecycle/switch/control.hpp"

#include <algorithm>

namespace musher {

void Control::Take(ActuatorIndex i, bool denied) {
  ActuatorRecord& record = Of(i);
  const Epoch seen = record.report.epoch;
  const bool ours = record.control.incarnation == record.report.incarnation;
  if (seen >= kLastEpoch) {
    record.control.again.reset();
    record.control.rival_until.reset();
    return Degrade(i, kCodePermissionDenied, texts::EpochOutOfRange(seen));
  }
  // Our own epoch may be from a query of ours that a new process has received instead of the one
  // before: it is another controller's if it denies ours.
  const bool of_other = seen == machine_.epoch && !ours && (denied || record.control.rival_until);
  if (seen > machine_.epoch || of_other) {
    if (!MayRaise() && !machine_.start_up.restarted) return LeaveToOther(i);
    // Perhaps a running controller leads with it; then its heartbeat comes, and this one releases
    // control.
    if (!record.control.rival_until)
      record.control.rival_until = now_ + (config_.keys.empty() ? kRivalGrace : kSecuredRivalGrace);
    if (now_ < *record.control.rival_until) {
      record.control.again = record.control.rival_until;
      if (record.set_up_by)
        record.set_up_by =
            std::max(*record.set_up_by, *record.control.rival_until + kTakeControlPeriod);
      return;
    }
    if (IsReplacedElsewhere(i)) return record.control.again.reset();  // this step releases control
    if (!MayRaise()) return LeaveToOther(i);
    RaiseEpoch();
  }
  record.control.rival_until.reset();
  record.control.incarnation = record.report.incarnation;
  record.control.again = now_ + kTakeControlPeriod;
  Do(action::SendQuery{i, {machine_.epoch, record.report.number, false}});
}

bool Control::MayRaise() const {
  return machine_.phase == Phase::kStarting && !machine_.start_up.raised;
}

bool Control::IsReplacedElsewhere(ActuatorIndex i) const {
  const ActuatorRecord& record = Of(i);
  const bool waits = !record.control.rival_until || now_ < *record.control.rival_until;
  if (waits || !machine_.start_up.restarted) return false;
  return std::none_of(machine_.actuators.begin(), machine_.actuators.end(),
                      [&](const ActuatorRecord& other) {
                        const bool taken = other.control.incarnation == other.report.incarnation;
                        return !taken && other.report.host == machine_.host &&
                               other.report.epoch >= record.report.epoch;
                      });
}

// It is degraded until a person takes over, or it is restarted.
void Control::LeaveToOther(ActuatorIndex i) {
  ActuatorRecord& record = Of(i);
  record.control.again.reset();
  record.control.rival_until.reset();
  record.set_up_by.reset();
  Degrade(i, kCodePermissionDenied, texts::ControlledByAnother(record.report.epoch), record.cause);
  FallBack(i);
}

// Earlier controllers were here: above the highest of their epochs. The attached actuators get the
// new epoch at once.
void Control::RaiseEpoch() {
  std::optional<ActuatorIndex> highest;
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    const bool higher = !highest || Of(i).report.epoch > Of(*highest).report.epoch;
    if (Of(i).control.rival_until && higher) highest = i;
  }
  machine_.epoch = Of(*highest).report.epoch + 1;
  machine_.start_up.raised = true;
  saver_.Save(Stored::kEpoch);
  memory_.Lower(std::nullopt);  // that controller may have changed the state of the machine
  RecordMachine(kCodeOk, texts::EpochRaised(machine_.epoch, ConfigOf(*highest).name));
  for (const ActuatorIndex i : machine_.actuators.Indices()) {
    if (Of(i).presence != Presence::kPresent) continue;
    Do(action::SendQuery{i, {machine_.epoch, 0, false}});  // a waiting command there keeps waiting
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
