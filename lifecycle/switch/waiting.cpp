// A request for a switch while a late actuator is being driven to the state of the machine on its
// own. The request waits until that actuator is free, at most as long as its command may take. Then
// the switch is planned as if the request came only now: it begins, or is refused.

#include <utility>

#include "musher/lifecycle/decision.hpp"

namespace musher {
namespace {

// After its deadline an actuator is queried for the outcome: by then that is known.
constexpr Duration kAnswered = kQueryTimeout * kQueryAttempts + Milliseconds(100);

}  // namespace

// As with a switch under way: the same request joins the waiting one, a more urgent one goes on to
// take over, any other is refused. Returns whether the request is handled.
bool Decision::JoinWaiting(const event::SetStateRequested& requested,
                           std::optional<std::size_t> only, std::uint64_t request_record) {
  if (!machine_.waiting) return false;
  WaitingSwitch& waiting = *machine_.waiting;
  if (waiting.target == requested.target && waiting.only == only) {
    waiting.requests.push_back(requested.request);
    return true;
  }
  if (!only && Urgency(requested.target) > Urgency(waiting.target)) return false;
  const auto left = std::to_string(ToMilliseconds(waiting.until - now_));
  const Error busy{kCodeTargetBusy, "switch " + Describe(config_, waiting.target, waiting.only) +
                                        " is waiting to start; retry in " + left + " ms"};
  Refuse(requested.target, only, {requested.request}, machine_.state, busy, request_record);
  return true;
}

void Decision::Await(const Plan& plan, RequestId request, std::uint64_t request_record) {
  const Time until = *plan.free_by + kAnswered;
  machine_.waiting = WaitingSwitch{plan.target, plan.only, until, {request}, request_record};
  machine_.waiting->cause =
      Record({"switch", plan.only, 0, kCodeOk,
              "switch " + Describe(config_, plan.target, plan.only) + " waits at most " +
                  std::to_string(ToMilliseconds(until - now_)) + " ms: " + plan.refusal->message,
              0, request_record});
}

// Returns whether a change may let other actuators proceed.
bool Decision::BeginWaiting() {
  if (!machine_.waiting) return false;
  const Plan plan = MakePlan(config_, machine_, machine_.waiting->target, machine_.waiting->only);
  if (plan.free_by && now_ < machine_.waiting->until) return false;
  if (plan.refusal) {
    EndWaiting(*plan.refusal, machine_.waiting->cause);
    return true;
  }
  const WaitingSwitch waiting = *std::exchange(machine_.waiting, std::nullopt);
  Begin(plan, Purpose::kRequested, waiting.requests, waiting.cause);
  return true;
}

// Ends it without beginning the switch: nothing was sent for it.
void Decision::EndWaiting(const Error& why, std::uint64_t cause) {
  if (!machine_.waiting) return;
  const WaitingSwitch waiting = *std::exchange(machine_.waiting, std::nullopt);
  const State state = waiting.only ? Of(*waiting.only).state() : machine_.state;
  Refuse(waiting.target, waiting.only, waiting.requests, state, why, cause);
}

}  // namespace musher
