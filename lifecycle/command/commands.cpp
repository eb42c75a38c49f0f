#include "musher/lifecycle/command/commands.hpp"

#include <algorithm>

#include "musher/lifecycle/config/flow.hpp"

namespace musher {
namespace {

// Two clocks that are 100 ppm apart differ by 6 ms after this.
constexpr Duration kClockGoodFor = std::chrono::seconds(60);

}  // namespace

void Commands::Issue(ActuatorIndex i, CommandNumber number, const State& target, Duration budget,
                     bool detached) {
  machine_.number = std::max(machine_.number, number);
  ActuatorRecord& record = Of(i);
  record.command = PendingCommand{
      number, target, now_, now_ + budget, 0, detached, record.clock_theirs - record.clock_ours};
  if (target == kSelfCheck) record.join_tried = true;
  Do(action::SendSwitch{i,
                        {machine_.epoch, number, target, budget, record.clock_theirs,
                         now_ - record.clock_ours, record.report.incarnation, detached}});
}

// A report that was late on its way makes the actuator's clock appear slow, and so a command older
// than it is: the actuator refuses it, and its refusal brings the right clock. Nothing is sent
// again that an emergency stop since then forbids to switch on.
bool Commands::SendAgain(ActuatorIndex i) {
  const ActuatorRecord& record = Of(i);
  const PendingCommand command = *record.command;
  const bool was_younger = record.clock_theirs - record.clock_ours > command.clock_ahead;
  const bool stopped = machine_.emergency.stop || (machine_.current && machine_.current->stopped) ||
                       (record.report.held_by_stop && !record.set_again);
  const bool forbidden = stopped && MaySwitchOn(config_, record.state(), command.target);
  if (!was_younger || forbidden || command.queries > 0 || now_ >= command.deadline) return false;
  Issue(i, command.number, command.target, command.deadline - now_, command.detached);
  Of(i).command->sent = command.sent;
  return true;
}

// Stores a newer report. A callback that ended without a command of this controller (an overdue
// one, or one of the previous controller) may have led to any state.
void Commands::Accept(ActuatorIndex i, const ActuatorReport& report) {
  ActuatorRecord& record = Of(i);
  if (ConfigOf(i).protocol == Protocol::kRos2Lifecycle) RecordDoubles(i, report);
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
  const bool present = record.presence == Presence::kPresent;
  if (came_free && present && record.checked && !record.held) record.due = true;
  // A delayed report would make commands look older than they are. Once in a while a new one is
  // used anyway: clocks drift.
  const bool other_process = record.report.incarnation != report.incarnation;
  const bool came_faster = report.stamp - now_ >= record.clock_theirs - record.clock_ours;
  if (other_process || came_faster || now_ - record.clock_ours > kClockGoodFor) {
    record.clock_theirs = report.stamp;
    record.clock_ours = now_;
  }
  const bool moved = !other_process && present && !record.command &&
                     report.state != record.report.state &&
                     report.outcome_number == record.report.outcome_number;
  record.report = report;
  if (moved) Drifted(i);
  if (came_free && !record.checked && report.outcome_code != kCodeOk) {
    Degrade(i, report.outcome_code, texts::FailedLate(report.outcome_message));
  }
  stops_.Compare(report, i);
  if (report.number < kLastNumber) machine_.number = std::max(machine_.number, report.number);
}

// The link reports two nodes with its name in the place of a partial fault.
void Commands::RecordDoubles(ActuatorIndex i, const ActuatorReport& report) {
  const ActuatorReport& before = Of(i).report;
  if (report.degraded_reason == before.degraded_reason) return;
  if (report.degraded_code != kCodeOk) {
    RecordActuator(i, report.degraded_code, texts::TwoNodes(report.degraded_reason));
  } else if (before.incarnation == report.incarnation) {
    RecordActuator(i, kCodeOk,
                   texts::ActuatorRecovered(ConfigOf(i).name, "no other node has its name"));
  }
}

// Its state has changed without a command.
void Commands::Drifted(ActuatorIndex i) {
  ActuatorRecord& record = Of(i);
  if (!record.checked) record.join_tried = false;  // it may have been configured by hand
  const ActuatorReport& report = record.report;
  const bool succeeded = report.outcome_code == kCodeOk;
  record.cause = RecordActuator(
      i, kCodeStatusError,
      texts::ActuatorDrifted(ConfigOf(i).name, record.state(),
                             succeeded ? std::nullopt : std::optional(report.outcome_message)));
  const bool ends = machine_.phase == Phase::kStopping || machine_.phase == Phase::kStopped;
  if (record.state() == kTearDown && !ends) {
    Degrade(i, kCodeStateInvalid, texts::TornDownAlone(), record.cause);
  } else if (record.fault && record.fault->event == EventName::kTornDownAlone) {
    record.fault.reset();  // what it had reported was not true
    if (record.health == Health::kHung) {
      Degrade(i, kCodeTimeout, texts::StillHung(), record.cause);
    }
  }
  if (!record.held && MayFollow(i)) record.due = true;
}

void Commands::QueryOrLose(ActuatorIndex i) {
  PendingCommand& command = *Of(i).command;
  if (command.queries >= kQueryAttempts) {
    return LoseConnection(i, texts::QueryUnanswered(command.target), Of(i).cause);
  }
  if (command.queries == 0) {
    Of(i).cause =
        RecordActuator(i, kCodeTimeout,
                       texts::CommandUnanswered(ConfigOf(i).name, command.deadline - command.sent,
                                                command.target, HasQuery(ConfigOf(i).protocol)),
                       machine_.current ? machine_.current->cause : Of(i).cause);
  }
  ++command.queries;
  command.deadline = now_ + kQueryTimeout;
  Do(action::SendQuery{i, {machine_.epoch, command.number, true}});
}

CommandResult Commands::EvaluateReport(ActuatorIndex i, const PendingCommand& command) const {
  const ActuatorReport& report = Of(i).report;
  const Duration time = now_ - command.sent;
  if (report.outcome_number == command.number) {
    if (report.outcome_code == kCodeOk) return DoneUnlessContradicted(i, "");
    return {ActuatorOutcome::kFailed, report.outcome_code,
            texts::Reported(ActuatorOutcome::kFailed, report.outcome_message), true};
  }
  if (report.busy_number == command.number) {
    return {ActuatorOutcome::kOverdue, kCodeTimeout, texts::StillBusy(command.target, time), true};
  }
  return {ActuatorOutcome::kOverdue, kCodeTimeout, texts::HadNotStarted(command.target, time),
          false};
}

CommandResult Commands::DoneUnlessContradicted(ActuatorIndex i, const std::string& message) const {
  const ActuatorRecord& record = Of(i);
  const State& target = record.command->target;
  if (target == kSelfCheck && record.report.degraded_code != kCodeOk) {
    return {ActuatorOutcome::kDone, record.report.degraded_code,
            texts::DoneDegraded(record.report.degraded_reason), true};
  }
  if (target == kSelfCheck || record.state() == target) {
    return {ActuatorOutcome::kDone, kCodeOk, texts::Reported(ActuatorOutcome::kDone, message),
            true};
  }
  return {ActuatorOutcome::kFailed, kCodeStatusError,
          texts::ContradictedBy(record.state().Shortened()), true};
}

void Commands::ReportUnchecked(ActuatorIndex i) {
  const ActuatorRecord& record = Of(i);
  if (record.command || record.report.busy() || record.free_by) return;  // perhaps with its check
  const bool passes_by_itself = !config_.RankOf(record.state()) && !record.join_tried;
  if (record.state() == machine_.state || passes_by_itself || record.checked || record.fault)
    return;
  Degrade(i, kCodeStatusError, texts::SelfCheckMissing(record.state()));
}

}  // namespace musher
