// The invariants of commands that wait at an actuator, of clients' calls, and of switch outcomes.

#include <algorithm>
#include <iterator>

#include "musher/lifecycle/config/flow.hpp"
#include "musher/simulation/checker.hpp"

namespace musher::simulation {
namespace {

// The clocks of two hosts are compared by the report with the shortest transit time.
constexpr Duration kCommandClockSlack = Milliseconds(100);
// A client's process notices within this that a controller has ended: the missed heartbeats, and a
// grace for a reply under way.
constexpr Duration kNotifiedWithin = std::chrono::seconds(4);
constexpr Duration kClientPeriod = Milliseconds(200);  // of the checks
// A request in a stable state has a reply, or the service is not available.
constexpr Duration kRepliedAtRest = std::chrono::seconds(12);

}  // namespace

// Runs after each step of an actuator: an accepted command that waits behind a callback still
// waits, has begun, or was cancelled for a reason that its sender knows.
void Checker::CheckWaiting(const std::string& name, std::size_t host,
                           const ActuatorReport& report) {
  const ActuatorCore* core = robot_.processes().CoreOf(name, host);
  auto& known = waiting_[{name, host}];
  const std::optional<Waiting> before = known;
  known.reset();
  if (core != nullptr && core->waiting) {
    known = Waiting{report.incarnation, report.epoch, core->waiting->command};
  }
  if (!before || before->incarnation != report.incarnation) return;
  const SwitchCommand& command = before->command;
  if (known && known->command.number >= command.number) return;  // the same, or a newer one
  const bool begun =
      report.busy_number >= command.number || report.outcome_number >= command.number;
  const bool stopped = report.emergency_stop != 0 && (command.target == report.state ||
                                                      Rises(config_, report.state, command.target));
  if (begun || stopped || report.epoch > before->epoch || report.state == kTearDown) return;
  const auto sent = sent_commands_.find({before->epoch, *config_.IndexOf(name), command.number});
  if (sent == sent_commands_.end()) return;
  // A newer one need not have arrived: the query about it fences this one as well.
  const auto next = std::next(sent);
  const bool newer_sent = next != sent_commands_.end() &&
                          std::get<0>(next->first) == before->epoch &&
                          std::get<1>(next->first) == *config_.IndexOf(name);
  if (newer_sent || IsGivenUp(sent->first)) return;
  const Duration age = robot_.network().now() - sent->second.sent;
  if (age + kCommandClockSlack >= sent->second.budget) return;
  ReportViolation(Invariant::kNoCommandDropped,
                  name + " drops the accepted command to " + command.target + " after " +
                      std::to_string(ToMilliseconds(age)) + " of " +
                      std::to_string(ToMilliseconds(sent->second.budget)) +
                      " ms, without a newer command");
}

// The controller has lost the actuator and reported that outcome for what it had sent.
void Checker::NoteGivenUp(Epoch epoch, ActuatorIndex i) {
  const auto after = sent_commands_.lower_bound({epoch, i + 1, CommandNumber()});
  if (after == sent_commands_.begin()) return;
  const CommandKey& last = std::prev(after)->first;
  if (std::get<0>(last) == epoch && std::get<1>(last) == i) given_up_[{epoch, i}] = last;
}

// When the actuator is available again, the query that attaches it fences a command that its
// controller has given up.
bool Checker::IsGivenUp(const CommandKey& command) const {
  const auto last = given_up_.find({std::get<0>(command), std::get<1>(command)});
  return last != given_up_.end() && command <= last->second;
}

// A controller writes a reply to a client.
void Checker::OnReplyWritten(const ControllerProcess& controller, const std::string& service) {
  const Machine& machine = controller.shell().machine();
  const Time now = robot_.network().now();
  if (machine.phase == Phase::kFenced) {
    // A caller that waits gets a refusal at the moment of the fence.
    const auto fenced = fenced_at_.emplace(controller.serial(), now).first->second;
    if (now == fenced) return;
  } else if (controller.begun()) {
    return;
  }
  ReportViolation(Invariant::kOnlyLeaderReplies,
                  "a controller that does not lead replies to " + service);
}

void Checker::CheckClients() {
  const Time now = robot_.network().now();
  if (now < check_clients_at_) return;
  check_clients_at_ = now + kClientPeriod;
  for (const Client::Request* request : robot_.OpenRequests()) {
    if (!request->orphaned || request->notified || now - *request->orphaned < kNotifiedWithin)
      continue;
    ReportViolation(Invariant::kClientGetsOutcome,
                    "a client that requested " + request->target +
                        " is not notified that the controller has ended");
  }
}

void Checker::CheckClientsAtRest() {
  const Time now = robot_.network().now();
  for (const Client::Request* request : robot_.OpenRequests()) {
    if (now - request->requested < kRepliedAtRest) continue;
    ReportViolation(Invariant::kClientGetsOutcome,
                    "a client that requested " + request->target + " receives no outcome");
  }
}

void Checker::OnReply(std::uint64_t request, const SwitchResult& result) {
  ++checks_;
  const auto open = open_requests_.extract(request);
  if (open.empty()) {
    return ReportViolation(Invariant::kOneReplyPerRequest,
                           "a request for " + result.target + " got two replies");
  }
  just_replied_.insert(result.target);
  if (result.outcome == SwitchOutcome::kSuperseded && !urgent_requested_ &&
      result.code != kCodePermissionDenied) {
    ReportViolation(Invariant::kPolicyNeverSupersedes,
                    "the switch to " + result.target + " is superseded (" + result.reason +
                        "), although nothing urgent was requested");
  }
  const bool done =
      result.outcome == SwitchOutcome::kDone || result.outcome == SwitchOutcome::kDoneDegraded;
  // Beyond a partition a second controller may lead, with other actuators: the result is about
  // those of the controller that replies.
  const ControllerProcess* controller = robot_.leader();
  for (std::size_t which = 0; which < 2; ++which) {
    const ControllerProcess* replying = robot_.controller(which);
    if (replying == nullptr || replying->serial() != open.mapped().controller) continue;
    CheckTornDown(*replying, result);
    controller = replying;
  }
  const bool ranked = config_.RankOf(result.target) && result.target != kTearDown;
  if (!done || !result.actuator.empty() || !ranked || controller == nullptr) return;
  requested_state_at_ = robot_.age();
  const Machine& machine = controller->shell().machine();
  CheckNotDegraded(machine, result);
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const std::string& name = config_.actuators[i].name;
    const ActuatorReport* report = robot_.ReportOf(i, machine.actuators[i].report);
    if (report == nullptr || IsExcused(machine, i, result)) continue;
    if (report->state == result.target) continue;
    ReportViolation(Invariant::kDoneIsComplete, "the switch to " + result.target +
                                                    " is reported as " +
                                                    std::string(OutcomeName(result.outcome)) +
                                                    ", but " + name + " is in " + report->state);
  }
}

// Whether an actuator need not be in the state that "done" reports: it is listed as degraded, still
// joining, reports false states, or joined too late to take part.
bool Checker::IsExcused(const Machine& machine, ActuatorIndex i, const SwitchResult& result) const {
  const std::string& name = config_.actuators[i].name;
  const ActuatorRecord& record = machine.actuators[i];
  const auto& degraded = result.degraded;
  if (std::find(degraded.begin(), degraded.end(), name) != degraded.end()) return true;
  const bool took_part =
      std::any_of(result.actuators.begin(), result.actuators.end(), [&](const ActuatorResult& one) {
        return one.name == name && one.outcome == ActuatorOutcome::kDone;
      });
  const bool away = record.presence != Presence::kPresent || !record.checked || record.fault;
  const bool joining = record.due || record.command || record.suspended || (away && !took_part);
  return joining || false_reporters_.contains(name) || self_switched_.contains(name) ||
         robot_.ReportOf(i, record.report)->incarnation != record.report.incarnation;
}

// "done-degraded" lists an actuator that is not available, or that failed in this switch. An
// earlier fault is neither.
void Checker::CheckNotDegraded(const Machine& machine, const SwitchResult& result) {
  if (result.outcome != SwitchOutcome::kDoneDegraded) return;
  const bool all_did =
      std::all_of(result.actuators.begin(), result.actuators.end(),
                  [](const ActuatorResult& one) { return one.outcome == ActuatorOutcome::kDone; });
  const bool all_there = std::all_of(
      machine.actuators.begin(), machine.actuators.end(), [&](const ActuatorRecord& record) {
        return record.presence == Presence::kPresent && record.state() == result.target;
      });
  if (!all_did || !all_there) return;
  ReportViolation(Invariant::kDoneIsComplete,
                  "the switch to " + result.target + " is reported as done-degraded (" +
                      result.reason + "), although all actuators are in that state");
}

}  // namespace musher::simulation
