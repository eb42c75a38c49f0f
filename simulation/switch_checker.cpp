#include "musher/simulation/switch_checker.hpp"

#include <algorithm>

#include "musher/lifecycle/config/flow.hpp"

namespace musher::simulation {
namespace {

// A client's process notices within this that a controller has ended: the missed heartbeats, and a
// grace for a reply under way.
constexpr Duration kNotifiedWithin = std::chrono::seconds(4);
constexpr Duration kClientPeriod = Milliseconds(200);  // of the checks
// A request in a stable state has a reply, or the service is not available.
constexpr Duration kRepliedAtRest = std::chrono::seconds(12);

}  // namespace

void SwitchChecker::CheckChange(const SimulatedController& controller) {
  const Machine& machine = controller.shell().machine();
  Seen& seen = seen_[controller.serial()];
  const auto before = config_.RankOf(seen.state);
  const auto rank = config_.RankOf(machine.state);
  if (before && rank && *rank > *before) {
    // Several switches may have ended since.
    const bool requested =
        seen.requested_state == machine.state || policy_.ByPolicy(controller, machine.state) ||
        std::any_of(just_replied_.begin(), just_replied_.end(), [&](const State& state) {
          const auto other = config_.RankOf(state);
          return other && *other >= *rank;
        });
    const std::string what = "the machine went from " + seen.state + " to " + machine.state;
    if (!requested)
      ReportViolation(Invariant::kNoUnrequestedActivation, what + ", which was not requested");
    if (seen.stopped && machine.emergency.stop) {
      ReportViolation(Invariant::kEmergencyStopHolds, what + " during an emergency stop");
    }
  }
  if (!machine.recorded_state.empty() && machine.recorded_state != machine.state) {
    ReportViolation(
        Invariant::kStatesRecorded,
        "the machine is in " + machine.state + ", the journal records " + machine.recorded_state);
  }
  if (seen.state != machine.state) policy_.CheckPolicyChange(controller, seen.state);
  seen.state = machine.state;
  seen.stopped = machine.emergency.stop.has_value();
  const bool requested = (seen.requested && machine.state == seen.requested_state) ||
                         just_replied_.contains(machine.state);
  if (requested && !machine.current) {
    rest_.NoteRequestedState(controller.serial());
  }
  seen.requested_state.reset();
  if (machine.current && IsRequested(*machine.current))
    seen.requested_state = machine.current->target;
  seen.requested = machine.current && machine.current->purpose == Purpose::kRequested;
  if (machine.waiting) {  // the switch may begin and end in one step
    seen.requested_state = machine.waiting->target;
    seen.requested = true;
  }
}

std::uint64_t SwitchChecker::OnRequest(const SimulatedController& controller, const State& target) {
  urgent_requested_ |= target == kError || target == kTearDown;
  open_requests_[next_request_] = {target, controller.serial()};
  return next_request_++;
}

// A controller writes a reply to a client.
void SwitchChecker::OnReplyWritten(const SimulatedController& controller,
                                   const std::string& service) {
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

void SwitchChecker::CheckClients() {
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

void SwitchChecker::CheckAtRest() {
  if (open_requests_.empty()) return;
  ReportViolation(Invariant::kOneReplyPerRequest,
                  "a request for " + open_requests_.begin()->second.target + " has no reply");
}

void SwitchChecker::CheckClientsAtRest() {
  const Time now = robot_.network().now();
  for (const Client::Request* request : robot_.OpenRequests()) {
    if (now - request->requested < kRepliedAtRest) continue;
    ReportViolation(Invariant::kClientGetsOutcome,
                    "a client that requested " + request->target + " receives no outcome");
  }
}

void SwitchChecker::OnReply(std::uint64_t request, const SwitchResult& result) {
  const auto open = open_requests_.extract(request);
  if (open.empty()) {
    return ReportViolation(Invariant::kOneReplyPerRequest,
                           "a request for " + result.target + " got two replies");
  }
  just_replied_.insert(result.target);
  // A switch of one actuator keeps no fallback waiting.
  if (result.outcome == SwitchOutcome::kSuperseded && !urgent_requested_ &&
      result.actuator.empty() && result.code != kCodePermissionDenied) {
    ReportViolation(Invariant::kPolicyNeverSupersedes,
                    "the switch to " + result.target + " is superseded (" + result.reason +
                        "), although nothing urgent was requested");
  }
  const bool done =
      result.outcome == SwitchOutcome::kDone || result.outcome == SwitchOutcome::kDoneDegraded;
  // Beyond a partition a second controller may lead other actuators: the result is about the
  // actuators of the controller that replies.
  const SimulatedController* controller = robot_.leader();
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* replying = robot_.controller(which);
    if (replying == nullptr || replying->serial() != open.mapped().controller) continue;
    tear_down_.CheckTornDown(*replying, result);
    tear_down_.NoteTornDownAlone(*replying, result);
    holds_.OnReply(*replying, result);
    controller = replying;
  }
  const bool ranked = config_.RankOf(result.target) && result.target != kTearDown;
  if (!done || !result.actuator.empty() || !ranked || controller == nullptr) return;
  rest_.NoteRequestedState(controller->serial());
  const Machine& machine = controller->shell().machine();
  CheckNotDegraded(machine, result);
  CheckSecondProcesses(*controller, result);
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

bool SwitchChecker::OnPolicyReply(std::uint64_t request, const event::PolicyRequested& requested) {
  if (open_requests_.erase(request) == 0) {
    ReportViolation(Invariant::kOneReplyPerRequest, "a request to the policy got two replies");
    return false;
  }
  just_replied_.insert(requested.what == PolicyRequest::kKeep ? requested.state : State(kActive));
  return true;
}

void SwitchChecker::OnControllerKilled(const SimulatedController& controller) {
  std::erase_if(open_requests_, [&](const auto& request) {
    return request.second.controller == controller.serial();
  });
}

// Whether another controller commands the actuator since: with a higher epoch, or beyond a
// partition with the same one.
bool SwitchChecker::ObeysAnother(const Machine& machine, const ActuatorReport& report) const {
  if (report.epoch > machine.epoch) return true;
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* other = robot_.controller(which);
    if (other == nullptr || !other->leads() || &other->shell().machine() == &machine) continue;
    if (other->shell().machine().epoch >= machine.epoch) return true;
  }
  return false;
}

// Whether an actuator need not be in the state that "done" reports: it is listed as degraded, still
// joining, reports false states, joined too late to take part, or obeys a newer controller since:
// one that was frozen reports what was done before.
bool SwitchChecker::IsExcused(const Machine& machine, ActuatorIndex i,
                              const SwitchResult& result) const {
  const std::string& name = config_.actuators[i].name;
  const KnownActuator& known = machine.actuators[i];
  const auto& degraded = result.degraded;
  if (std::find(degraded.begin(), degraded.end(), name) != degraded.end()) return true;
  const bool took_part =
      std::any_of(result.actuators.begin(), result.actuators.end(), [&](const ActuatorResult& one) {
        return one.name == name && one.outcome == ActuatorOutcome::kDone;
      });
  if (ObeysAnother(machine, *robot_.ReportOf(i, known.report))) return true;
  const bool away = known.presence != Presence::kPresent || !known.checked || known.fault;
  const bool joining = known.due || known.command || known.suspended || (away && !took_part);
  return joining || context_.false_reporters.contains(name) || commands_.HasSwitchedItself(name) ||
         robot_.ReportOf(i, known.report)->incarnation != known.report.incarnation;
}

// "done-degraded" lists an actuator that is not available, or that failed in this switch. An
// earlier fault is neither.
void SwitchChecker::CheckNotDegraded(const Machine& machine, const SwitchResult& result) {
  if (result.outcome != SwitchOutcome::kDoneDegraded) return;
  const bool all_did =
      std::all_of(result.actuators.begin(), result.actuators.end(),
                  [](const ActuatorResult& one) { return one.outcome == ActuatorOutcome::kDone; });
  const bool all_there = std::all_of(machine.actuators.begin(), machine.actuators.end(),
                                     [&](const KnownActuator& known) {
                                       return known.presence == Presence::kPresent &&
                                              known.state() == result.target && !known.other;
                                     });
  if (!all_did || !all_there) return;
  ReportViolation(Invariant::kDoneIsComplete,
                  "the switch to " + result.target + " is reported as done-degraded (" +
                      result.reason + "), although all actuators are in that state");
}

// "done" is a claim about every process of an actuator whose status has arrived: one on a second
// host, which no command reaches, may be more active than the target.
void SwitchChecker::CheckSecondProcesses(const SimulatedController& controller,
                                         const SwitchResult& result) {
  if (result.outcome != SwitchOutcome::kDone) return;
  const Machine& machine = controller.shell().machine();
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    const std::string& name = config_.actuators[i].name;
    for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
      const ActuatorReport* report = robot_.processes().ReportOf(name, host);
      if (report == nullptr || report->host == machine.actuators[i].report.host) continue;
      const bool excused = context_.false_reporters.contains(name) ||
                           commands_.HasSwitchedItself(name) || ObeysAnother(machine, *report);
      if (excused || !Rises(config_, result.target, report->state)) continue;
      if (!HasArrived(controller, name, host)) continue;
      ReportViolation(Invariant::kDoneIsComplete,
                      "the switch to " + result.target + " is reported as done, but " + name +
                          " on host " + robot_.hosts().name(host) + " is in " + report->state);
    }
  }
}

// Whether the status of that process has had the time to arrive at the controller.
bool SwitchChecker::HasArrived(const SimulatedController& controller, const std::string& name,
                               std::size_t host) const {
  const Time started = robot_.processes().StartOf(name, host);
  return robot_.network().now() - started >= kReceivedAfter &&
         !WasDisturbed(controller, name, host, kReceivedAfter);
}

}  // namespace musher::simulation
