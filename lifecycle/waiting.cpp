// A request for a switch while a late actuator is on its own way to where the machine is: it waits
// until that one is free, at most as long as its order may take. It is then begun as if it came
// only now, so that whatever is against it is told, or refused.

#include <utility>

#include "musher/lifecycle/decision.hpp"

namespace musher {
namespace {

// After its deadline an actuator is asked how the command stands: by then that is known.
constexpr Duration kAnswered = kAskTimeout * kAskAttempts + Milliseconds(100);

}  // namespace

// As with a switch under way: the same again joins the one that waits, a more urgent one goes on to
// take over, anything else is refused. Says whether the request is dealt with.
bool Decision::JoinWaiting(const event::SetStateRequested& requested,
                           std::optional<std::size_t> only, std::uint64_t asked) {
  if (!machine_.waiting) return false;
  WaitingSwitch& waiting = *machine_.waiting;
  if (waiting.target == requested.target && waiting.only == only) {
    waiting.requests.push_back(requested.request);
    return true;
  }
  if (!only && Urgency(requested.target) > Urgency(waiting.target)) return false;
  const auto left = std::to_string(ToMilliseconds(waiting.until - now_));
  const Error busy{kCodeTargetBusy, "a switch " + Describe(config_, waiting.target, waiting.only) +
                                        " waits to be begun; come again in " + left + " ms"};
  Refuse(requested.target, only, {requested.request}, machine_.state, busy, asked);
  return true;
}

void Decision::Await(const Plan& plan, RequestId request, std::uint64_t asked) {
  const Time until = *plan.free_by + kAnswered;
  machine_.waiting = WaitingSwitch{plan.target, plan.only, until, {request}, asked};
  machine_.waiting->cause =
      Record({"switch", plan.only, 0, kCodeOk,
              "a switch " + Describe(config_, plan.target, plan.only) + " waits at most " +
                  std::to_string(ToMilliseconds(until - now_)) + " ms: " + plan.refusal->message,
              0, asked});
}

// Says whether something changed that may let others go on.
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

// It is not begun: nothing was sent for it.
void Decision::EndWaiting(const Error& why, std::uint64_t cause) {
  if (!machine_.waiting) return;
  const WaitingSwitch waiting = *std::exchange(machine_.waiting, std::nullopt);
  const State state = waiting.only ? Of(*waiting.only).state() : machine_.state;
  Refuse(waiting.target, waiting.only, waiting.requests, state, why, cause);
}

}  // namespace musher
