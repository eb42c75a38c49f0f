// What has to hold of commands that wait at an actuator, of the calls of clients, and of outcomes.

#include <algorithm>
#include <iterator>

#include "musher/lifecycle/flow.hpp"
#include "musher/simulation/checker.hpp"

namespace musher::simulation {
namespace {

// What a client's process needs to see that a controller has ended: the heartbeats that are missed,
// and a grace for an answer under way.
// The clocks of two hosts are compared by the report that took least time.
constexpr Duration kCommandClockSlack = Milliseconds(100);
constexpr Duration kToldWithin = std::chrono::seconds(4);
constexpr Duration kClientPeriod = Milliseconds(200);  // of looking
// A request that comes while the machine is at rest is answered, or there is no such service.
constexpr Duration kAnsweredAtRest = std::chrono::seconds(12);

}  // namespace

// After each step of an actuator: a command that had been accepted and waited behind a callback
// waits on, begins, or is over for a reason that its sender knows.
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
  const auto order = orders_.find({before->epoch, *config_.IndexOf(name), command.number});
  if (order == orders_.end()) return;
  // A newer one need not have come: the question about it fences this one as well.
  const auto next = std::next(order);
  const bool newer_sent = next != orders_.end() && std::get<0>(next->first) == before->epoch &&
                          std::get<1>(next->first) == *config_.IndexOf(name);
  if (newer_sent || IsGivenUp(before->epoch, *config_.IndexOf(name))) return;
  const Duration age = robot_.network().now() - order->second.sent;
  if (age + kCommandClockSlack >= order->second.budget) return;
  ReportViolation(Invariant::kNotCancelled,
                  name + " drops the command to " + command.target +
                      " that it had accepted, after " + std::to_string(ToMilliseconds(age)) +
                      " of " + std::to_string(ToMilliseconds(order->second.budget)) +
                      " ms, and no newer one came");
}

// Whether the controller that sent the command has lost the actuator since and reported that
// outcome. When the actuator is available again, the query that attaches it fences the old command.
bool Checker::IsGivenUp(std::uint64_t epoch, std::size_t i) const {
  for (std::size_t which = 0; which < 2; ++which) {
    const ControllerProcess* controller = robot_.controller(which);
    if (controller == nullptr || controller->shell().machine().epoch != epoch) continue;
    const ActuatorRecord& record = controller->shell().machine().actuators[i];
    if (!record.order && record.presence != Presence::kPresent) return true;
  }
  return false;
}

// A controller writes an answer to a client.
void Checker::OnReplyWritten(const ControllerProcess& controller, const std::string& service) {
  const Machine& machine = controller.shell().machine();
  const Time now = robot_.network().now();
  if (machine.phase == Phase::kFenced) {
    // A caller that waits is told of the fence as it happens.
    const auto fenced = fenced_at_.emplace(controller.serial(), now).first->second;
    if (now == fenced) return;
  } else if (controller.begun()) {
    return;
  }
  ReportViolation(Invariant::kLeaderAnswers, "a controller that does not lead answers " + service);
}

void Checker::CheckClients() {
  const Time now = robot_.network().now();
  if (now < check_clients_at_) return;
  check_clients_at_ = now + kClientPeriod;
  for (const Client::Request* request : robot_.OpenRequests()) {
    if (!request->orphaned || request->told || now - *request->orphaned < kToldWithin) continue;
    ReportViolation(Invariant::kClientHears, "a client that had asked for " + request->target +
                                                 " is not told that the controller has ended");
  }
}

void Checker::CheckClientsAtRest() {
  const Time now = robot_.network().now();
  for (const Client::Request* request : robot_.OpenRequests()) {
    if (now - request->asked < kAnsweredAtRest) continue;
    ReportViolation(Invariant::kClientHears,
                    "a client that had asked for " + request->target + " hears of no outcome");
  }
}

// "done-degraded" names one that is not there, or that this switch has failed with. A fault of
// before is neither.
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
  ReportViolation(Invariant::kDoneIsDone, "the switch to " + result.target +
                                              " is told to be done-degraded (" + result.reason +
                                              "), and all are there");
}

}  // namespace musher::simulation
