#include "musher/simulation/command_checker.hpp"

#include <algorithm>
#include <iterator>

#include "musher/lifecycle/config/flow.hpp"

namespace musher::simulation {
namespace {

// How much older than its budget a command may be when it begins: the clocks of two hosts are
// compared by the report with the shortest transit time.
constexpr Duration kClockSlack = Milliseconds(100);

}  // namespace

void CommandChecker::OnSend(const Machine& machine, const action::SendSwitch& send) {
  const SwitchCommand& command = send.command;
  const std::uint64_t controller = SerialOf(machine);
  // The rollback of a single actuator leads back up.
  const bool back = machine.current && machine.current->rollback.under_way && machine.current->only;
  sent_commands_[{command.epoch, send.actuator, command.number}] = {
      robot_.network().now(),
      command.budget,
      MayRise(machine, command.target),
      controller,
      back || authority_.HasReason(controller, machine.state, command.target),
      {release_.IsRequestedSinceStop(controller, send.actuator, command.target), ++context_.order}};
}

// An actuator may be commanded up by a requested switch, or to the machine's state.
bool CommandChecker::MayRise(const Machine& machine, const State& target) const {
  const auto& s = machine.current;
  const bool may = s && (IsRequested(*s) || s->purpose == Purpose::kPolicy);  // see CheckRaise
  if (may && s->target == target) return true;
  const auto place = config_.RankOf(machine.state);
  const auto rank = config_.RankOf(target);
  if (rank && place && *rank <= *place) return true;
  // A rollback of a single actuator may lead back up.
  return machine.current && machine.current->rollback.under_way && machine.current->only;
}

// A controller has raised its epoch: what it has sent and what waits at the actuators keeps
// waiting, under the new one.
void CommandChecker::CarryCommandsOver(std::uint64_t controller, Epoch from, Epoch to) {
  const std::vector<std::pair<CommandKey, SentCommand>> sent(
      sent_commands_.lower_bound({from, ActuatorIndex(), CommandNumber()}),
      sent_commands_.lower_bound({from + 1, ActuatorIndex(), CommandNumber()}));
  for (const auto& [key, command] : sent) {
    if (command.controller != controller) continue;
    sent_commands_.try_emplace({to, std::get<1>(key), std::get<2>(key)}, command);
  }
}

void CommandChecker::OnBegun(const std::string& name, std::size_t host,
                             const ActuatorReport& before, const ActuatorReport& report) {
  const bool rises = Rises(config_, report.state, report.target);
  const std::string what = name + " begins " + report.target + " in " + report.state;
  if (rises && report.emergency_stop != 0 && before.emergency_stop == report.emergency_stop) {
    return ReportViolation(Invariant::kEmergencyStopHolds,
                           what + " although it has latched an emergency stop");
  }
  if (report.target == kSetUp) return;
  if (report.busy_number == 0) {
    self_switched_[name] = robot_.network().now();
    if (rises) ReportViolation(Invariant::kNoUnrequestedActivation, what + " without a command");
    return;
  }
  self_switched_.erase(name);
  const auto sent = sent_commands_.find({report.epoch, *config_.IndexOf(name), report.busy_number});
  if (sent == sent_commands_.end()) {
    return ReportViolation(Invariant::kNoStaleCommand,
                           what + " although no controller has sent that command");
  }
  const Duration age = robot_.network().now() - sent->second.sent;
  if (age > sent->second.budget + kClockSlack) {
    ReportViolation(Invariant::kNoStaleCommand,
                    what + ", by a command that is " + std::to_string(ToMilliseconds(age)) +
                        " ms old and had " + std::to_string(ToMilliseconds(sent->second.budget)) +
                        " ms");
  }
  // A controller lowers an actuator that claims to be more active than it is.
  const bool lowered =
      context_.false_reporters.contains(name) && !Rises(config_, kDeActive, report.target);
  if (rises && !sent->second.may_rise && !lowered) {
    ReportViolation(Invariant::kNoUnrequestedActivation, what + ", which was not requested");
  }
  if (rises && !sent->second.has_reason) {
    ReportViolation(Invariant::kRisesAreRecorded,
                    what + ", for which its controller has recorded no reason");
  }
  if (rises) authority_.CheckRise(sent->second.controller, name, host, report);
  release_.CheckAfterRelease(name, host, before, report, sent->second.basis);
}

// Runs after each step of an actuator: an accepted command that waits behind a callback still
// waits, has begun, or was cancelled for a reason that its sender knows.
void CommandChecker::CheckWaiting(const std::string& name, std::size_t host,
                                  const ActuatorReport& report) {
  const SimulatedProcesses& processes = robot_.processes();
  const ActuatorCore* core = processes.CoreOf(name, host);
  const std::uint64_t process = processes.SerialOf(host, processes.PidOf(name, host));
  auto& known = waiting_[{name, host}];
  const std::optional<WaitingCommand> before = known;
  known.reset();
  if (core != nullptr && core->waiting) {
    const bool same = before && before->process == process &&
                      before->incarnation == report.incarnation &&
                      before->command.number == core->waiting->command.number;
    const bool stopped = report.emergency_stop != 0 || (same && before->stopped);
    known =
        WaitingCommand{process, report.incarnation, report.epoch, core->waiting->command, stopped};
  }
  if (!before || before->process != process) return;
  if (before->incarnation != report.incarnation) return;
  const SwitchCommand& command = before->command;
  if (known && known->command.number >= command.number) return;  // the same, or a newer one
  const bool begun =
      report.busy_number >= command.number || report.outcome_number >= command.number;
  // It may have missed the stop, and received its release.
  const bool released = core != nullptr && core->last_before_release >= command.number;
  const bool stopped =
      (report.emergency_stop != 0 || before->stopped || released) &&
      (command.target == report.state || MaySwitchOn(config_, report.state, command.target));
  if (begun || stopped || report.epoch > before->epoch || report.state == kTearDown) return;
  const auto sent = sent_commands_.find({before->epoch, *config_.IndexOf(name), command.number});
  if (sent == sent_commands_.end()) return;
  // It waited behind the way to the safe state that the actuator went to by itself after that.
  const auto alone = self_switched_.find(name);
  const bool before_alone =
      alone != self_switched_.end() && sent->second.sent <= alone->second + kClockSlack;
  if (before_alone && MaySwitchOn(config_, report.state, command.target)) return;
  // A newer one need not have arrived: the query about it fences this one as well.
  const auto next = std::next(sent);
  const bool newer_sent = next != sent_commands_.end() &&
                          std::get<0>(next->first) == before->epoch &&
                          std::get<1>(next->first) == *config_.IndexOf(name);
  if (newer_sent || IsGivenUp(sent->first)) return;
  const Duration age = robot_.network().now() - sent->second.sent;
  if (age + kClockSlack >= sent->second.budget) return;
  ReportViolation(Invariant::kNoCommandDropped,
                  name + " drops the accepted command to " + command.target + " after " +
                      std::to_string(ToMilliseconds(age)) + " of " +
                      std::to_string(ToMilliseconds(sent->second.budget)) +
                      " ms, without a newer command");
}

// The controller has lost the actuator and reported that outcome for what it had sent.
void CommandChecker::NoteGivenUp(Epoch epoch, ActuatorIndex i) {
  const auto after = sent_commands_.lower_bound({epoch, i + 1, CommandNumber()});
  if (after == sent_commands_.begin()) return;
  const CommandKey& last = std::prev(after)->first;
  if (std::get<0>(last) == epoch && std::get<1>(last) == i) given_up_[{epoch, i}] = last;
}

// When the actuator is available again, the query that attaches it fences a command that its
// controller has given up.
bool CommandChecker::IsGivenUp(const CommandKey& command) const {
  const auto last = given_up_.find({std::get<0>(command), std::get<1>(command)});
  return last != given_up_.end() && command <= last->second;
}

}  // namespace musher::simulation
