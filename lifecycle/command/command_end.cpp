// The end of a command, and the loss of an actuator.

#include "musher/lifecycle/command/commands.hpp"

#include <algorithm>

namespace musher {
namespace {

// The delay before a failed self-check is repeated; doubled each time.
constexpr Duration kFirstCheckAgain = std::chrono::seconds(10);
constexpr int kMostCheckDoublings = 5;  // about five minutes

}  // namespace

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
  }
  if (command.target == kSelfCheck) NoteCheck(i, end.outcome);
  // Driven on once it is free, unless a check is still running.
  if (end.outcome == ActuatorOutcome::kOverdue && command.target != kSelfCheck) Of(i).due = true;
  if (Leg* leg = LegUnderWay(i)) {
    EndLeg(*leg, end, now_);
  } else {
    EndOwn(i, command, end);
  }
  // Of an actuator that cannot be queried nothing more is known until it is restarted.
  const bool unknown = !HasQuery(ConfigOf(i).protocol) &&
                       end.outcome == ActuatorOutcome::kOverdue &&
                       machine_.phase != Phase::kStopping;
  if (unknown && MayRestart(i) && ProcessOf(i) != 0) {
    Hang(i, true, texts::HungIn(command.target, took));
  }
}

// A self-check may fail for a passing reason, such as load: a failed one is repeated.
void Commands::NoteCheck(ActuatorIndex i, ActuatorOutcome outcome) {
  FailedChecks& failed = Of(i).failed_checks;
  if (outcome != ActuatorOutcome::kFailed && outcome != ActuatorOutcome::kOverdue) {
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
  ActuatorRecord& record = Of(i);
  if (record.restart.requested) return EndTornDown(i, end);
  if (end.outcome == ActuatorOutcome::kDone) {
    record.due = command.target == kSelfCheck || record.state() != PlaceOf(i);
    return;
  }
  if (end.outcome == ActuatorOutcome::kLost) return;  // what follows depends on how it was lost
  Degrade(i, end.code, texts::CommandNotDone(command.target, end.outcome, end.text.message),
          record.cause);
  // A repeated check that fails again is no new loss: a person may have gone on without it.
  const bool repeated = command.target == kSelfCheck && record.failed_checks.count > 1;
  if (!repeated) FallBack(i);
}

// Its TearDown before a restart has ended. A process of Musher's protocol exits by itself after
// that, and gets SIGTERM only if it does not; a program of another protocol waits for SIGTERM.
void Commands::EndTornDown(ActuatorIndex i, const CommandResult& end) {
  ActuatorRecord& record = Of(i);
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
    record.process.termination->terminate_at = now_ + grace;
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

void Commands::Lose(ActuatorIndex i, const RecordText& how, RecordId cause, std::int32_t code) {
  ActuatorRecord& record = Of(i);
  const bool torn_down = record.state() == kTearDown;
  const bool had_answered = record.presence == Presence::kPresent;
  if (record.command) End(i, {ActuatorOutcome::kLost, code, how, true, cause});
  record.presence = Presence::kLost;
  record.control.again.reset();
  record.checked = false;
  record.held = record.held && torn_down;  // an actuator torn down alone stays detached
  record.due = false;
  record.restart.reset_at.reset();
  record.control.rival_until.reset();
  record.free_by.reset();
  record.report.target = {};
  record.report.busy_number = 0;
  if (machine_.phase == Phase::kStopping) return;
  if (torn_down) {
    return Degrade(i, kCodeStateInvalid, texts::TornDownAlone(), cause);
  }
  // The reason why its SetUp failed says more than that its process has exited.
  if (!record.fault || had_answered) Degrade(i, code, how, cause);
}

void Commands::LoseConnection(ActuatorIndex i, const RecordText& how, RecordId cause) {
  Lose(i, how, cause);
  if (!MayRestart(i) || ProcessOf(i) == 0) FallBack(i);
}

void Commands::Hang(ActuatorIndex i, bool silent, const RecordText& how) {
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
