// One command to one actuator, with a definite outcome.

#include <algorithm>
#include <utility>

#include "musher/lifecycle/decision.hpp"

namespace musher {

// Stores a newer report. A callback that ended without a command of this controller (an overdue
// one, or one of the previous controller) may have led to any state.
void Decision::Accept(std::size_t i, const ActuatorReport& report) {
  ActuatorRecord& record = Of(i);
  // The report that it was busy may have been missed.
  const bool was_busy =
      record.report.busy() || (report.incarnation == record.report.incarnation &&
                               report.outcome_number != record.report.outcome_number);
  const bool came_free = was_busy && !report.busy() && !record.command;
  if (!report.busy()) record.free_by.reset();
  // In the run phase a check leaves the state as it is.
  const bool passed_late = (report.state == kSelfCheck && record.report.state != kSelfCheck) ||
                           (record.report.target == kSelfCheck && report.outcome_code == kCodeOk);
  if (came_free && passed_late) record.checked = true;
  if (came_free && record.checked && !record.held) record.due = true;
  // A delayed report would make commands look older than they are. Once in a while a new one is
  // used anyway: clocks drift.
  const bool other_process = record.report.incarnation != report.incarnation;
  const bool came_faster = report.stamp - now_ >= record.clock_theirs - record.clock_ours;
  if (other_process || came_faster || now_ - record.clock_ours > kClockGoodFor) {
    record.clock_theirs = report.stamp;
    record.clock_ours = now_;
  }
  const bool moved = !other_process && record.presence == Presence::kPresent && !record.command &&
                     report.state != record.report.state &&
                     report.outcome_number == record.report.outcome_number;
  record.report = report;
  if (moved) Drifted(i);
  if (came_free && !record.checked && report.outcome_code != kCodeOk) {
    Degrade(i, report.outcome_code, "failed after its deadline: " + report.outcome_message);
  }
  HoldTo(report, i);
  if (report.number < kLastNumber) machine_.number = std::max(machine_.number, report.number);
}

// Its state has changed without a command.
void Decision::Drifted(std::size_t i) {
  ActuatorRecord& record = Of(i);
  if (!record.checked) record.join_tried = false;  // it may have been configured by hand
  const bool succeeded = record.report.outcome_code == kCodeOk;
  record.cause =
      RecordActuator(i, kCodeStatusError,
                     ConfigOf(i).name + " has switched to " + record.state() + " by itself" +
                         (succeeded ? "" : ": " + record.report.outcome_message));
  const bool ends = machine_.phase == Phase::kStopping || machine_.phase == Phase::kStopped;
  if (record.state() == kTearDown && !ends) {
    Degrade(i, kCodeStateInvalid, kTornDownAlone, record.cause);
  } else if (record.fault && record.fault->message == kTornDownAlone) {
    record.fault.reset();  // what it had reported was not true
    if (record.health == Health::kHung) {
      Degrade(i, kCodeTimeout, "hung: it has not recovered yet", record.cause);
    }
  }
  if (!record.held && MayFollow(i)) record.due = true;
}

void Decision::On(const event::Replied& replied) {
  ActuatorRecord& record = Of(replied.actuator);
  if (replied.report.incarnation != record.report.incarnation) return;
  if (replied.report.stamp >= record.report.stamp) Accept(replied.actuator, replied.report);
  const bool denied = replied.verdict == Verdict::kRefused && replied.code == kCodePermissionDenied;
  if (replied.query && denied && replied.report.epoch > machine_.epoch)
    return TakeControl(replied.actuator);
  if (denied && replied.report.epoch == machine_.epoch) {
    // Another controller with the same epoch has taken it, unnoticed: on the other side of a
    // partition.
    record.controlled = 0;
    TakeControl(replied.actuator);
  }
  if (replied.query && denied && record.take_control_again) {
    record.take_control_again = now_ + kIntroductionPeriod;  // our heartbeat has not arrived yet
  }
  if (replied.query && replied.verdict == Verdict::kDone && record.take_control_again) {
    Attach(replied.actuator);
  }
  if (!record.command || record.command->number != replied.number) return;
  if (replied.query && record.command->queries == 0)
    return;  // it answers TakeControl(), not the query
  if (replied.query)
    return EndCommand(replied.actuator, EvaluateReport(replied.actuator, *record.command));
  switch (replied.verdict) {
    case Verdict::kDone:
      return EndCommand(replied.actuator,
                        DoneUnlessContradicted(replied.actuator, replied.message));
    case Verdict::kRefused:
      return EndCommand(replied.actuator, {record.command->queries > 0 ? ActuatorOutcome::kOverdue
                                                                       : ActuatorOutcome::kRefused,
                                           replied.code, replied.message, false});
    case Verdict::kFailed:
      return EndCommand(replied.actuator,
                        {ActuatorOutcome::kFailed, replied.code, replied.message, true});
  }
}

// The actuator reports that the command is done; its own status may contradict that.
CommandResult Decision::DoneUnlessContradicted(std::size_t i, const std::string& message) const {
  const ActuatorRecord& record = Of(i);
  const State& target = record.command->target;
  if (target == kSelfCheck && record.report.degraded_code != kCodeOk) {
    return {ActuatorOutcome::kDone, record.report.degraded_code,
            "degraded: " + record.report.degraded_reason, true};
  }
  if (target == kSelfCheck || record.state() == target) {
    return {ActuatorOutcome::kDone, kCodeOk, message, true};
  }
  return {ActuatorOutcome::kFailed, kCodeStatusError,
          "it reports done, but its state is " + record.state().substr(0, 64), true};
}

void Decision::Issue(std::size_t i, std::uint64_t number, const State& target, Duration budget,
                     bool apart) {
  machine_.number = std::max(machine_.number, number);
  Of(i).command = PendingCommand{number, target, now_, now_ + budget, 0};
  if (target == kSelfCheck) Of(i).join_tried = true;
  Do(action::SendSwitch{i, number, target, budget, apart});
}

// The outcome of the command by the latched status of a queried actuator.
CommandResult Decision::EvaluateReport(std::size_t i, const PendingCommand& command) const {
  const ActuatorReport& report = Of(i).report;
  const std::string time = std::to_string(ToMilliseconds(now_ - command.sent)) + " ms";
  if (report.outcome_number == command.number) {
    if (report.outcome_code == kCodeOk) return DoneUnlessContradicted(i, "");
    return {ActuatorOutcome::kFailed, report.outcome_code, report.outcome_message, true};
  }
  if (report.busy_number == command.number) {
    return {ActuatorOutcome::kOverdue, kCodeTimeout,
            "still busy with " + command.target + " after " + time, true};
  }
  return {ActuatorOutcome::kOverdue, kCodeTimeout,
          "had not started " + command.target + " after " + time, false};
}

void Decision::QueryOrLose(std::size_t i) {
  PendingCommand& command = *Of(i).command;
  if (command.queries >= kQueryAttempts) {
    return LoseConnection(
        i, "no answer, not even to the query for the outcome of " + command.target, Of(i).cause);
  }
  if (command.queries == 0) {
    const std::string next = ConfigOf(i).protocol == Protocol::kCyberdog
                                 ? "; its protocol has no query for the outcome of " +
                                       command.target + ", so its state is unknown until it answers"
                                 : "; querying the outcome of " + command.target;
    Of(i).cause = RecordActuator(
        i, kCodeTimeout,
        ConfigOf(i).name + " did not answer within " +
            std::to_string(ToMilliseconds(command.deadline - command.sent)) + " ms" + next,
        machine_.current ? machine_.current->cause : Of(i).cause);
  }
  ++command.queries;
  command.deadline = now_ + kQueryTimeout;
  Do(action::SendQuery{i, command.number, true});
}

void Decision::CheckCommands() {
  for (std::size_t i = 0; i < machine_.actuators.size(); ++i) {
    ActuatorRecord& record = Of(i);
    if (record.command && record.command->deadline <= now_) QueryOrLose(i);
    if (record.take_control_again && *record.take_control_again <= now_) TakeControl(i);
    if (record.free_by && *record.free_by <= now_) EvaluateFoundBusy(i);
  }
}

// A callback that it was found busy with, or that was superseded, has its deadline, too.
void Decision::EvaluateFoundBusy(std::size_t i) {
  ActuatorRecord& record = Of(i);
  record.free_by.reset();
  if (!record.report.busy() || record.command || record.presence != Presence::kPresent) return;
  const State& target = record.report.target;
  Degrade(i, kCodeTimeout,
          "still busy with " + target + ", which no switch waits for, after " +
              std::to_string(ToMilliseconds(config_.TimeFor(i, target))) + " ms");
  Do(action::SendQuery{i, record.report.number, true});
  FallBack(i);
}

void Decision::EndCommand(std::size_t i, const CommandResult& given) {
  const PendingCommand command = *Of(i).command;
  const CommandResult end = Tolerate(i, command, given);
  const std::string took = std::to_string(ToMilliseconds(now_ - command.sent)) + " ms";
  const std::uint64_t cause = end.cause != 0                             ? end.cause
                              : machine_.current && command.queries == 0 ? machine_.current->cause
                                                                         : Of(i).cause;
  const std::uint64_t recorded = RecordActuator(
      i, end.code,
      ConfigOf(i).name + ": " + command.target + " " + std::string(OutcomeName(end.outcome)) +
          " after " + took + (end.message.empty() ? "" : ": " + end.message),
      cause);
  if (end.outcome != ActuatorOutcome::kDone) Of(i).cause = recorded;
  Of(i).command.reset();
  if (end.outcome == ActuatorOutcome::kDone) {
    // A ROS 2 node that has reached a state is configured, and answers.
    const bool configured =
        ConfigOf(i).protocol == Protocol::kRos2Lifecycle && config_.RankOf(command.target);
    if (command.target == kSelfCheck || configured) Of(i).checked = true;
    // A failed check stays recorded until one passes, a hang until it ends; a TearDown clears every
    // fault.
    const bool well = Of(i).checked && Of(i).health != Health::kHung && !Of(i).suspended;
    if (well || command.target == kTearDown) Of(i).fault.reset();
  }
  // Driven on once it is free, unless a check is still running.
  if (end.outcome == ActuatorOutcome::kOverdue && command.target != kSelfCheck) Of(i).due = true;
  if (Leg* leg = LegUnderWay(i)) {
    EndLeg(*leg, end);
  } else {
    EndJoin(i, command, end);
  }
  // Of an actuator that cannot be queried nothing more is known until it is restarted.
  const bool unknown = ConfigOf(i).protocol == Protocol::kCyberdog &&
                       end.outcome == ActuatorOutcome::kOverdue &&
                       machine_.phase != Phase::kStopping;
  if (unknown && MayRestart(i) && ProcessOf(i) != 0) {
    Hang(i, true, "hung: in " + command.target + " for " + took + ", and it cannot be queried");
  }
}

// The part of the switch under way that waits for this actuator; null when there is none.
Leg* Decision::LegUnderWay(std::size_t i) {
  if (!machine_.current) return nullptr;
  Switch& s = *machine_.current;
  std::vector<Leg>& legs = s.rolling_back ? s.back : s.legs;
  const auto found = std::find_if(legs.begin(), legs.end(), [i](const Leg& leg) {
    return leg.actuator == i && leg.progress == Leg::Progress::kUnderWay;
  });
  return found == legs.end() ? nullptr : &*found;
}

void Decision::Lose(std::size_t i, const std::string& how, std::uint64_t cause, std::int32_t code) {
  ActuatorRecord& record = Of(i);
  const bool torn_down = record.state() == kTearDown;
  const bool had_answered = record.presence == Presence::kPresent;
  if (record.command) EndCommand(i, {ActuatorOutcome::kLost, code, how, true, cause});
  record.presence = Presence::kLost;
  record.take_control_again.reset();
  record.checked = false;
  record.held = record.held && torn_down;  // an actuator torn down alone stays detached
  record.due = false;
  record.healthy_at.reset();
  record.outbid_at.reset();
  record.free_by.reset();
  record.report.target.clear();
  record.report.busy_number = 0;
  if (machine_.phase == Phase::kStopping) return;
  if (torn_down) {
    return Degrade(i, kCodeStateInvalid, kTornDownAlone, cause);
  }
  // The reason why its SetUp failed says more than that its process has exited.
  if (!record.fault || had_answered) Degrade(i, code, how, cause);
}

// The connection to it is lost. The state of a process that this controller has started is
// determined: if it has exited or hangs, it is restarted.
void Decision::LoseConnection(std::size_t i, const std::string& how, std::uint64_t cause) {
  Lose(i, how, cause);
  if (!MayRestart(i) || ProcessOf(i) == 0) FallBack(i);
}

// The exit of a process can overtake its last sample.
void Decision::AssumeTornDown(std::size_t i) {
  if (!Of(i).command || Of(i).command->target != kTearDown) return;
  Of(i).report.state = State(kTearDown);
  Of(i).report.apart = true;  // it was commanded alone, the machine continues
  EndCommand(i, {ActuatorOutcome::kDone, kCodeOk, "", true});
}

void Decision::On(const event::Vanished& vanished) {
  ActuatorRecord& record = Of(vanished.actuator);
  if (record.other && record.other->incarnation == vanished.incarnation) record.other.reset();
  if (record.report.incarnation != vanished.incarnation) return;
  if (record.dead == vanished.incarnation) return;  // its successor may be starting already
  const bool was_there =
      record.presence == Presence::kPresent || record.presence == Presence::kStarting;
  if (!vanished.for_good) {
    if (was_there) LoseConnection(vanished.actuator, vanished.how);
    return;
  }
  record.dead = vanished.incarnation;
  AssumeTornDown(vanished.actuator);
  if (record.health != Health::kHung) record.health = Health::kCrashed;
  if (was_there) Lose(vanished.actuator, "crashed: " + vanished.how);
  if (record.restart_at) return;  // our process has exited before
  if (record.given_up) return FallBack(vanished.actuator);
  if (record.process != 0) return Terminate(vanished.actuator, record.process, kEndTime);
  Recover(vanished.actuator);
}

}  // namespace musher
