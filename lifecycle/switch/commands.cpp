#include "musher/lifecycle/switch/commands.hpp"

#include <algorithm>

#include "musher/lifecycle/config/flow.hpp"

namespace musher {
namespace {

// Two clocks that are 100 ppm apart differ by 6 ms after this.
constexpr Duration kClockGoodFor = std::chrono::seconds(60);

// The delay before a failed self-check is repeated; doubled each time.
constexpr Duration kFirstCheckAgain = std::chrono::seconds(10);
constexpr int kMostCheckDoublings = 5;  // about five minutes

}  // namespace

void Commands::Issue(ActuatorIndex i, CommandNumber number, const State& target, Duration budget,
                     bool detached) {
  machine_.number = std::max(machine_.number, number);
  KnownActuator& known = Of(i);
  known.command = PendingCommand{
      number, target, now_, now_ + budget, 0, detached, known.clock_theirs - known.clock_ours};
  if (target == kSelfCheck) known.join_tried = true;
  Do(action::SendSwitch{i,
                        {machine_.epoch, number, target, budget, known.clock_theirs,
                         now_ - known.clock_ours, known.report.incarnation, detached}});
}

// A report that was late on its way makes the actuator's clock appear slow. Then a command appears
// older than it is: the actuator refuses it, and the refusal has the right clock. A command that an
// emergency stop forbids since then is not sent again.
bool Commands::SendAgain(ActuatorIndex i) {
  const KnownActuator& known = Of(i);
  const PendingCommand command = *known.command;
  const bool was_younger = known.clock_theirs - known.clock_ours > command.clock_ahead;
  const bool stopped = machine_.emergency.stop || (machine_.current && machine_.current->stopped) ||
                       MustBeSetAgain(machine_, known);
  const bool forbidden = stopped && (MaySwitchOn(config_, known.state(), command.target) ||
                                     SwitchesOnAgain(config_, known.state(), command.target));
  if (!was_younger || forbidden || command.queries > 0 || now_ >= command.deadline) return false;
  Issue(i, command.number, command.target, command.deadline - now_, command.detached);
  Of(i).command->sent = command.sent;
  return true;
}

// Stores a newer report. A callback that ended without a command of this controller (an overdue
// one, or one of the previous controller) may have led to any state.
void Commands::Accept(ActuatorIndex i, const ActuatorReport& report) {
  KnownActuator& known = Of(i);
  if (ConfigOf(i).protocol == Protocol::kRos2Lifecycle) RecordDoubles(i, report);
  // The report that it was busy may have been missed.
  const bool was_busy =
      known.report.busy() || (report.incarnation == known.report.incarnation &&
                              report.outcome_number != known.report.outcome_number);
  const bool came_free = was_busy && !report.busy() && !known.command;
  if (!report.busy()) known.free_by.reset();
  if (!report.busy()) {
    std::erase_if(known.superseded, [&](const auto& one) { return one.number <= report.number; });
  }
  // In the run phase a check leaves the state as it is.
  const bool passed_late = (report.state == kSelfCheck && known.report.state != kSelfCheck) ||
                           (known.report.target == kSelfCheck && report.outcome_code == kCodeOk);
  if (came_free && passed_late) known.checked = true;
  const bool present = known.presence == Presence::kPresent;
  if (came_free && present && known.checked && !known.held) known.due = true;
  // A delayed report would make commands look older than they are. Once in a while a new one is
  // used anyway: clocks drift.
  const bool other_process = known.report.incarnation != report.incarnation;
  const bool came_faster = report.stamp - now_ >= known.clock_theirs - known.clock_ours;
  if (other_process || came_faster || now_ - known.clock_ours > kClockGoodFor) {
    known.clock_theirs = report.stamp;
    known.clock_ours = now_;
  }
  const bool moved = !other_process && present && !known.command &&
                     report.state != known.report.state &&
                     report.outcome_number == known.report.outcome_number;
  // For a process that was lost, what was sent to it counts as received, too: see Lose().
  const CommandNumber sent = other_process || present ? CommandNumber() : known.report.number;
  known.report = report;
  known.report.number = std::max(report.number, sent);
  if (moved) Drifted(i);
  if (came_free && !known.checked && report.outcome_code != kCodeOk) {
    Degrade(i, report.outcome_code, texts::FailedLate(report.outcome_message));
  }
  stops_.Compare(report, i);
  if (report.number < kLastNumber) machine_.number = std::max(machine_.number, report.number);
}

// The link reports a second node of the actuator's name in the place of a partial fault.
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
  KnownActuator& known = Of(i);
  if (!known.checked) known.join_tried = false;  // it may have been configured by hand
  const ActuatorReport& report = known.report;
  const bool succeeded = report.outcome_code == kCodeOk;
  known.cause = RecordActuator(
      i, kCodeStatusError,
      texts::ActuatorDrifted(ConfigOf(i).name, known.state(),
                             succeeded ? std::nullopt : std::optional(report.outcome_message)));
  const bool ends = machine_.phase == Phase::kStopping || machine_.phase == Phase::kStopped;
  if (known.state() == kTearDown && !ends) {
    Degrade(i, kCodeStateInvalid, texts::TornDownAlone(), known.cause);
  } else if (known.fault && known.fault->event == EventName::kTornDownAlone) {
    known.fault.reset();  // what it had reported was not true
    if (known.health == Health::kHung) {
      Degrade(i, kCodeTimeout, texts::StillHung(), known.cause);
    }
  }
  if (!known.held && MayFollow(i)) known.due = true;
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
  const KnownActuator& known = Of(i);
  const State& target = known.command->target;
  if (target == kSelfCheck && known.report.degraded_code != kCodeOk) {
    return {ActuatorOutcome::kDone, known.report.degraded_code,
            texts::DoneDegraded(known.report.degraded_reason), true};
  }
  if (target == kSelfCheck || known.state() == target) {
    return {ActuatorOutcome::kDone, kCodeOk, texts::Reported(ActuatorOutcome::kDone, message),
            true};
  }
  return {ActuatorOutcome::kFailed, kCodeStatusError,
          texts::ContradictedBy(known.state().Shortened()), true};
}

void Commands::ReportUnchecked(ActuatorIndex i) {
  const KnownActuator& known = Of(i);
  if (known.command || known.report.busy() || known.free_by) return;  // perhaps with its check
  const bool passes_by_itself = !config_.RankOf(known.state()) && !known.join_tried;
  if (known.state() == machine_.state || passes_by_itself || known.checked || known.fault) return;
  Degrade(i, kCodeStatusError, texts::SelfCheckMissing(known.state()));
}

// --- the end of a command, and the loss of an actuator ---

void EndLeg(Leg& leg, const CommandResult& end, Time now) {
  leg.progress = Leg::Progress::kEnded;
  leg.outcome = end.outcome;
  leg.code = end.code;
  leg.message = end.text.message;
  leg.event = end.text.event;
  leg.ran = end.ran;
  leg.duration = now - leg.started;
}

void Commands::End(ActuatorIndex i, const CommandResult& given) {
  const PendingCommand command = *Of(i).command;
  const CommandResult end = Tolerate(i, command, given);
  const Duration took = now_ - command.sent;
  const RecordId cause = end.cause != 0                             ? end.cause
                         : machine_.current && command.queries == 0 ? machine_.current->cause
                                                                    : Of(i).cause;
  const RecordId recorded = RecordActuator(
      i, end.code,
      texts::CommandEnded(ConfigOf(i).name, command.target, end.outcome, took, end.text.message),
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
    if (command.target == kError && ConfigOf(i).Lists(kSelfCheck)) Of(i).checked = false;
    if (config_.RankOf(command.target)) Of(i).lost_in = {};
  }
  if (command.target == kSelfCheck) NoteCheck(i, end);
  // An overdue actuator is driven again once it is free; one whose check still runs is not.
  if (end.outcome == ActuatorOutcome::kOverdue && command.target != kSelfCheck) Of(i).due = true;
  if (Leg* leg = LegUnderWay(i)) {
    EndLeg(*leg, end, now_);
  } else {
    EndOwn(i, command, end);
  }
  // An actuator that cannot be queried stays unknown until it is restarted.
  const bool unknown = !HasQuery(ConfigOf(i).protocol) &&
                       end.outcome == ActuatorOutcome::kOverdue &&
                       machine_.phase != Phase::kStopping;
  if (unknown && MayRestart(i) && ProcessOf(i) != 0) {
    MarkHung(i, true, texts::HungIn(command.target, took));
  }
}

// A self-check may fail for a passing reason, such as load: a check that has failed, or has passed
// as degraded, is repeated.
void Commands::NoteCheck(ActuatorIndex i, const CommandResult& end) {
  FailedChecks& failed = Of(i).failed_checks;
  const bool degraded = end.outcome == ActuatorOutcome::kDone && end.code != kCodeOk;
  if (!degraded && end.outcome != ActuatorOutcome::kFailed &&
      end.outcome != ActuatorOutcome::kOverdue) {
    failed = {};
    return;
  }
  failed.at = now_ + kFirstCheckAgain * (1 << std::min(failed.count, kMostCheckDoublings));
  ++failed.count;
}

// A self-check that fails with a code that is not critical counts as passed, and the actuator is
// degraded.
CommandResult Commands::Tolerate(ActuatorIndex i, const PendingCommand& command,
                                 const CommandResult& end) {
  if (command.target != kSelfCheck) return end;
  Of(i).tolerated.reset();
  const auto& critical = ConfigOf(i).critical_codes;
  const bool tolerated = end.outcome == ActuatorOutcome::kFailed && critical &&
                         std::find(critical->begin(), critical->end(), end.code) == critical->end();
  if (!tolerated) return end;
  const std::string& message = end.text.message;
  const std::string why = message.empty() ? "its self-check failed" : message;
  Of(i).tolerated = Error{end.code, why};
  return {ActuatorOutcome::kDone, end.code, texts::DoneDegraded(why), true, end.cause};
}

// The part of the switch under way that waits for this actuator; null when there is none.
Leg* Commands::LegUnderWay(ActuatorIndex i) {
  if (!machine_.current) return nullptr;
  Switch& s = *machine_.current;
  std::vector<Leg>& legs = s.driven_legs();
  const auto found = std::find_if(legs.begin(), legs.end(), [i](const Leg& leg) {
    return leg.actuator == i && leg.progress == Leg::Progress::kUnderWay;
  });
  return found == legs.end() ? nullptr : &*found;
}

// The end of a command that was not part of a switch.
void Commands::EndOwn(ActuatorIndex i, const PendingCommand& command, const CommandResult& end) {
  KnownActuator& known = Of(i);
  if (known.restart.requested) return EndTornDown(i, end);
  if (end.outcome == ActuatorOutcome::kDone) {
    known.due = command.target == kSelfCheck || known.state() != PlaceOf(i);
    if (!known.due && IsKeptApart(i)) known.held = true;
    return;
  }
  if (end.outcome == ActuatorOutcome::kLost) return;  // what follows depends on how it was lost
  if (command.target == kSelfCheck) known.checked = false;  // also where one has passed before
  Degrade(i, end.code, texts::CommandNotDone(command.target, end.outcome, end.text.message),
          known.cause);
  // A repeated check that fails again is no new loss: a person may have gone on without it.
  const bool repeated = command.target == kSelfCheck && known.failed_checks.count > 1;
  if (!repeated) FallBack(i);
}

// Its TearDown before a restart has ended. A process of Musher's protocol exits by itself after
// that, and gets SIGTERM only if it does not; a program of another protocol waits for SIGTERM.
void Commands::EndTornDown(ActuatorIndex i, const CommandResult& end) {
  KnownActuator& known = Of(i);
  const bool ends_itself =
      end.outcome == ActuatorOutcome::kDone && ConfigOf(i).protocol == Protocol::kMusher;
  const std::int32_t pid = ProcessOf(i);
  if (pid == 0) {
    if (end.outcome == ActuatorOutcome::kLost) return;  // what follows depends on how it was lost
    Lose(i, texts::PidUnknown());
    return processes_.Recover(i);
  }
  const Duration grace = ends_itself ? kExitGrace : Duration::zero();
  processes_.Terminate(i, pid, grace + kEndTime);
  if (ends_itself) {
    known.process.termination->terminate_at = now_ + grace;
  } else {
    Do(action::SignalProcess{i, pid, false});
  }
}

void Commands::AssumeTornDown(ActuatorIndex i) {
  if (!Of(i).command || Of(i).command->target != kTearDown) return;
  Of(i).report.state = State(kTearDown);
  Of(i).report.detached = true;  // it was commanded alone, the machine continues
  End(i, {ActuatorOutcome::kDone, kCodeOk, {}, true});
}

void Commands::StayDown(ActuatorIndex i) {
  KnownActuator& known = Of(i);
  if (!known.down_requested) return;
  known.report.state = State(kTearDown);
  known.report.target = {};
  known.report.detached = true;
  known.held = true;
}

// The state in which it is, or to which it may have come since its last report.
State Commands::MostActiveOf(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  State most = known.state();
  if (Rises(config_, most, known.report.target)) most = known.report.target;
  for (const State& target : known.BeforeNext()) {
    if (Rises(config_, most, target)) most = target;
  }
  return most;
}

void Commands::Lose(ActuatorIndex i, const RecordText& how, RecordId cause, std::int32_t code) {
  KnownActuator& known = Of(i);
  const bool torn_down = known.state() == kTearDown;
  const bool had_answered = known.presence == Presence::kPresent;
  const State in = MostActiveOf(i);
  // The command may still arrive. The query that takes control again fences it: once the query is
  // answered, the command has begun or never will.
  if (known.command) known.report.number = std::max(known.report.number, known.command->number);
  known.down_requested |=
      known.command && known.command->target == kTearDown && !known.restart.requested;
  const bool was_led_down = known.command && known.command->detached && !known.restart.requested &&
                            IsPlace(known.command->target);
  if (was_led_down) known.kept_in = known.command->target;
  if (known.command) End(i, {ActuatorOutcome::kLost, code, how, true, cause});
  known.presence = Presence::kLost;
  if (!torn_down && config_.RankOf(in)) known.lost_in = in;  // in a step of a start nothing is on
  known.control.again.reset();
  known.checked = false;
  known.held = known.held && torn_down;  // an actuator torn down alone stays detached
  known.due = false;
  known.restart.reset_at.reset();
  known.control.rival_until.reset();
  known.free_by.reset();
  known.superseded.clear();
  known.report.target = {};
  known.report.busy_number = 0;
  if (machine_.phase == Phase::kStopping) return;
  if (torn_down) {
    return Degrade(i, kCodeStateInvalid, texts::TornDownAlone(), cause);
  }
  // The reason why its SetUp failed says more than that its process has exited.
  if (!known.fault || had_answered) Degrade(i, code, how, cause);
}

void Commands::LoseConnection(ActuatorIndex i, const RecordText& how, RecordId cause) {
  Lose(i, how, cause);
  KnownActuator& known = Of(i);
  const bool is_restarted = known.restart.requested && ProcessOf(i) != 0;
  if (known.state() == kTearDown || is_restarted) return;
  if (!MayRestart(i) || ProcessOf(i) == 0) return FallBack(i);
  const auto& termination = known.process.termination;
  const bool is_ended = termination && !termination->for_silence;
  if (!is_ended) known.exit_by = now_ + kExitIsKnown;
}

void Commands::MarkHung(ActuatorIndex i, bool silent, const RecordText& how) {
  const std::int32_t pid = ProcessOf(i);
  const bool killable = MayRestart(i) && pid != 0;
  if (killable || silent) {
    Lose(i, how);
  } else {
    Degrade(i, kCodeTimeout, how);
  }
  if (!killable) return FallBack(i);
  Of(i).cause =
      RecordProcess(i, kCodeTimeout, texts::BacktraceStarted(ConfigOf(i).name, pid), Of(i).cause);
  processes_.Terminate(i, pid, kBacktraceTime);
  Do(action::TakeBacktrace{i, pid});
}

}  // namespace musher
