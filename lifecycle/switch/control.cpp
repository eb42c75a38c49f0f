#include "musher/lifecycle/switch/control.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/config/flow.hpp"

namespace musher {

void Control::Take(ActuatorIndex i, bool denied) {
  KnownActuator& known = Of(i);
  const Epoch seen = known.report.epoch;
  const bool ours = known.control.incarnation == known.report.incarnation;
  if (seen >= kLastEpoch) {
    known.control.again.reset();
    known.control.rival_until.reset();
    return Degrade(i, kCodePermissionDenied, texts::EpochOutOfRange(seen));
  }
  // The actuator may have our epoch because a new process has received a query for the process
  // before. It obeys another controller if it denies our epoch.
  const bool of_other = seen == machine_.epoch && !ours && (denied || known.control.rival_until);
  if (seen > machine_.epoch || of_other) {
    if (!MayRaise() && !machine_.start_up.restarted) return LeaveToOther(i);
    // Perhaps a running controller leads with that epoch: its heartbeat will arrive, and this
    // controller releases control.
    if (!known.control.rival_until)
      known.control.rival_until = now_ + (config_.keys.empty() ? kRivalGrace : kSecuredRivalGrace);
    if (now_ < *known.control.rival_until) {
      known.control.again = known.control.rival_until;
      if (known.set_up_by)
        known.set_up_by =
            std::max(*known.set_up_by, *known.control.rival_until + kTakeControlPeriod);
      return;
    }
    if (IsReplacedElsewhere(i)) return known.control.again.reset();  // this step releases control
    if (!MayRaise()) return LeaveToOther(i);
    RaiseEpoch();
  }
  known.control.rival_until.reset();
  known.control.incarnation = known.report.incarnation;
  known.control.again = now_ + kTakeControlPeriod;
  Do(action::SendQuery{i, {machine_.epoch, known.report.number, false}});
}

bool Control::MayRaise() const {
  return machine_.phase == Phase::kStarting && !machine_.start_up.raised;
}

bool Control::IsReplacedElsewhere(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  const bool waits = !known.control.rival_until || now_ < *known.control.rival_until;
  return !waits && machine_.start_up.restarted && !IsOfPredecessor(known.report.epoch);
}

bool Control::IsOfPredecessor(Epoch epoch) const {
  return std::any_of(machine_.actuators.begin(), machine_.actuators.end(),
                     [&](const KnownActuator& known) {
                       return !HasTaken(known) && known.report.host == machine_.host &&
                              known.report.epoch >= epoch;
                     });
}

bool Control::HasTaken(const KnownActuator& known) const {
  const bool queried = known.control.incarnation == known.report.incarnation;
  return queried && (known.met || known.report.host != machine_.host);
}

// The actuator is degraded until a person takes the machine over, or the actuator is restarted.
void Control::LeaveToOther(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  known.control.again.reset();
  known.control.rival_until.reset();
  known.set_up_by.reset();
  // A later status of the actuator is no new loss: a person may have gone on without it.
  const bool again = known.fault && known.fault->event == EventName::kControlledByAnother;
  Degrade(i, kCodePermissionDenied, texts::ControlledByAnother(known.report.epoch), known.cause);
  if (!again) FallBack(i);
}

// Raises our epoch above the highest epoch that an earlier controller has left at an actuator. The
// attached actuators get the new epoch at once.
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

// The other actuator for which this controller starts the process in which this one runs, too.
std::optional<ActuatorIndex> Control::StarterOf(ActuatorIndex i) const {
  const ActuatorReport& report = Of(i).report;
  if (!ConfigOf(i).command.empty() || report.pid == 0) return std::nullopt;
  for (const ActuatorIndex other : machine_.actuators.Indices()) {
    const bool is_it = Of(other).process.pid == report.pid && HostOf(other) == report.host;
    if (is_it && !ConfigOf(other).command.empty()) return other;
  }
  return std::nullopt;
}

void Control::Attach(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  known.control.again.reset();
  if (known.presence == Presence::kPresent) return;
  const bool late = machine_.start_up.set_up && machine_.phase != Phase::kStopping &&
                    machine_.phase != Phase::kStopped;
  known.presence = Presence::kPresent;
  known.exit_by.reset();
  known.set_up_by.reset();
  known.restart.at.reset();  // it was started by another party first
  known.fault.reset();
  const auto other = StarterOf(i);
  known.down_requested = known.down_requested && other;
  if (config_.RankOf(known.state())) known.lost_in = {};
  known.tolerated.reset();
  const bool beyond = known.state() == kSelfCheck || config_.RankOf(known.state());
  known.checked = (beyond && known.state() != kError) || !ConfigOf(i).Lists(kSelfCheck);
  known.join_tried = false;
  known.failed_checks = {};
  const bool in_place = IsPlace(known.state());
  // Only Musher's protocol says with which request an actuator was led there.
  const bool is_kept =
      ConfigOf(i).protocol != Protocol::kMusher && in_place && known.kept_in == known.state();
  known.held = known.report.detached || is_kept || known.down_requested;
  if (known.held || in_place) known.kept_in = known.held && in_place ? known.state() : State();
  // A person has led it on alone, and the controller before this one may not have stored that.
  const bool is_led = known.report.busy() && known.report.detached;
  if (is_led && known.report.target == kTearDown) known.down_requested = true;
  if (is_led && IsPlace(known.report.target)) known.kept_in = known.report.target;
  known.suspended = false;
  known.health = Health::kWell;
  known.due = late && known.checked && !known.held;
  const bool first = !std::exchange(known.met, true);
  // Where the machine goes, also by its start: its own state has no rank then.
  const auto& current = machine_.current;
  const State& place = current && !current->only ? current->target : machine_.state;
  // An actuator in SetUp has only just started: no command leads back to SetUp.
  known.found_below |= first && known.due && machine_.start_up.requests_nothing &&
                       known.state() != kSetUp && Rises(config_, known.state(), place);
  if (known.report.busy()) known.free_by = now_ + config_.TimeFor(i, known.report.target);
  known.cause = RecordActuator(i, kCodeOk,
                               texts::ActuatorPresent(ConfigOf(i).name, known.state(),
                                                      known.report.pid, known.report.target),
                               known.cause);
  if (machine_.emergency.stop && known.report.emergency_stop == 0) {
    Do(action::PublishEmergencyStop{*machine_.emergency.stop,
                                    true});  // it may have missed the stop
  }
  if (known.state() == kTearDown && known.held)
    Degrade(i, kCodeStateInvalid, texts::TornDownAlone(), known.cause);
  else if (known.down_requested && other)
    Degrade(i, kCodeStateInvalid, texts::StartedBeside(ConfigOf(*other).name), known.cause);
  processes_.EvaluateArrival(i);
}

}  // namespace musher
