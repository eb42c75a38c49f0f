// The life of a machine: ticks, transitions, and what happens when a state fails.

#include "musher/behavior/fsm/machine.hpp"

#include <algorithm>
#include <exception>
#include <utility>

namespace musher::fsm {
namespace {

// While this lives, calls that change the machine refuse.
class InTick {
 public:
  explicit InTick(bool& flag) : flag_(flag) { flag_ = true; }
  ~InTick() { flag_ = false; }
  InTick(const InTick&) = delete;
  InTick& operator=(const InTick&) = delete;

 private:
  bool& flag_;
};

Error Refusal(const std::string& machine, const char* why) {
  return {kCodeFailed, machine + ": " + why};
}

constexpr const char* kInTick = "a state or a listener cannot change the machine; it may Send()";

}  // namespace

// Runs a function of the current state; false when it threw, which has been dealt with then.
template <class Call>
bool Machine::Guard(Phase phase, Call&& call) {
  try {
    call();
    return true;
  } catch (const std::exception& thrown) {
    Fail(phase, thrown.what());
  } catch (...) {
    Fail(phase, "threw something that is no std::exception");
  }
  return false;
}

template <class Call>
void Machine::TellAll(Call&& call) {
  for (Listener* listener : listeners_) {
    try {
      call(*listener);
    } catch (...) {
      ++counts_.listener_faults;
    }
  }
}

Tick Machine::Now() const {
  Tick tick{.now = time_, .step = step_, .elapsed = time_ - entered_};
  if (mode_ == Mode::kTransitioning) {
    tick.target = target_;
    tick.transition_elapsed = time_ - transition_began_;
    tick.transition_time = transition_time_;
  }
  return tick;
}

void Machine::Advance(Time now) {
  step_ = last_tick_ && now > *last_tick_ ? now - *last_tick_ : Duration{};
  last_tick_ = now;
  time_ += step_;
}

Result<> Machine::Start(Time now) {
  if (in_tick_) return Refusal(name(), kInTick);
  if (!built_) return Refusal(name(), "cannot start before Build() has succeeded");
  if (running_) return Refusal(name(), "runs already");
  const InTick guard(in_tick_);
  running_ = true;
  ticks_ = 0;
  time_ = step_ = entered_ = {};
  last_tick_ = now;
  first_command_ = waiting_ = 0;
  unsafe_ = checks_.size();
  history_.Clear();
  fault_.reset();
  Enter(chart_.start, Cause::kStarted, kNoEvent);
  return Reached(chart_.start);
}

void Machine::RunOnce(Time now) {
  if (!running_ || in_tick_) return;
  const InTick guard(in_tick_);
  Advance(now);
  ++ticks_;
  if (!IsSafe()) return;
  if (mode_ == Mode::kTransitioning) {
    Proceed();
  } else {
    Decide();
  }
  if (running_) IsSafe();
}

// Whether every check is well. Goes to the safe state when one is not.
bool Machine::IsSafe() {
  for (std::size_t i = 0; i < checks_.size(); ++i) {
    bool safe = true;
    if (!Guard(Phase::kSafetyCheck, [&] { safe = checks_[i].is_safe(Now()); })) return false;
    if (safe) continue;
    unsafe_ = i;
    if (mode_ == Mode::kSafeStop) return true;  // is there; its state goes on
    Switch(safe_, Cause::kUnsafe, kNoEvent);
    return false;
  }
  if (mode_ == Mode::kSafeStop) unsafe_ = checks_.size();
  return true;
}

void Machine::Decide() {
  Tick tick = Now();
  tick.command = TakeCommand();
  Next next = Next::Stay();
  if (!Guard(Phase::kCheck, [&] { next = state(current_).CheckTransition(tick); })) return;
  // Not out of the safe state while a check fails.
  const bool held = mode_ == Mode::kSafeStop && unsafe_ != checks_.size();
  if (!next.stays() && !held) return Begin(next, tick.command);
  if (tick.command != kNoEvent) Unheeded(tick.command);
  Guard(Phase::kRun, [&] { state(current_).Run(tick); });
}

void Machine::Begin(const Next& next, EventId command) {
  if (!Declared(current_, next.target())) {
    return Fail(Phase::kCheck,
                "it went to " +
                    (Index(next.target()) < nodes_.size() ? std::string(Name(next.target()))
                                                          : "a state that there is not") +
                    ", which it has not declared");
  }
  mode_ = Mode::kTransitioning;
  target_ = next.target();
  cause_ = command;
  transition_began_ = time_;
  transition_time_ = next.time();
  Proceed();
}

void Machine::Proceed() {
  bool done = false;
  const Tick tick = Now();
  if (!Guard(Phase::kTransition, [&] { done = state(current_).Transition(tick); })) return;
  if (done) {
    Switch(target_, Cause::kDecided, cause_);
  } else if (tick.transition_elapsed > options_.longest_transition) {
    Fail(Phase::kTransition, "the transition to " + std::string(Name(target_)) + " does not end");
  }
}

// From the current state to `target`.
void Machine::Switch(StateId target, Cause cause, EventId command) {
  if (Guard(Phase::kExit, [&] { state(current_).OnExit(Now()); })) Enter(target, cause, command);
}

// The current state has been left, or there was none.
void Machine::Enter(StateId target, Cause cause, EventId command) {
  const Change change{time_, ticks_, current_, target, command, cause};
  current_ = target;
  entered_ = time_;
  mode_ = target == safe_ ? Mode::kSafeStop : Mode::kNormal;
  target_ = kNoState;
  if (mode_ == Mode::kNormal) unsafe_ = checks_.size();
  Remember(change);
  Guard(Phase::kEnter, [&] { state(current_).OnEnter(Now()); });
}

// The current state failed. It is left for the safe one; where that has failed, or there is none,
// the machine stops.
void Machine::Fail(Phase phase, std::string what) {
  ++counts_.faults;
  fault_ = Fault{current_, phase, time_, std::move(what)};
  TellAll([&](Listener& listener) { listener.OnFault(*this, *fault_); });
  if (safe_ == kNoState || current_ == safe_) return Halt();
  if (phase != Phase::kEnter && phase != Phase::kExit) {
    try {
      state(current_).OnExit(Now());
    } catch (...) {
      ++counts_.faults;  // it is being left because it failed; the first failure is the one told
    }
  }
  Enter(safe_, Cause::kFault, kNoEvent);
}

void Machine::Halt() {
  const Change change{time_, ticks_, current_, kNoState, kNoEvent, Cause::kFault};
  running_ = false;
  mode_ = Mode::kSafeStop;
  current_ = target_ = kNoState;
  Remember(change);
}

Result<> Machine::Stop() {
  if (in_tick_) return Refusal(name(), kInTick);
  if (!running_) return Ok();
  const InTick guard(in_tick_);
  try {
    state(current_).OnExit(Now());
  } catch (const std::exception& thrown) {
    ++counts_.faults;
    fault_ = Fault{current_, Phase::kExit, time_, thrown.what()};
  } catch (...) {
    ++counts_.faults;
    fault_ = Fault{current_, Phase::kExit, time_, "threw something that is no std::exception"};
  }
  const Change change{time_, ticks_, current_, kNoState, kNoEvent, Cause::kStopped};
  running_ = false;
  mode_ = Mode::kNormal;
  current_ = target_ = kNoState;
  Remember(change);
  TellAll([&](Listener& listener) { listener.OnChange(*this, change); });
  return Ok();
}

Result<> Machine::Force(StateId target) {
  if (in_tick_) return Refusal(name(), kInTick);
  if (!running_) return Refusal(name(), "does not run");
  if (Index(target) >= nodes_.size()) return Refusal(name(), "has no such state");
  const InTick guard(in_tick_);
  Switch(target, Cause::kForced, kNoEvent);
  return Reached(target);
}

Result<> Machine::Reset() {
  if (in_tick_) return Refusal(name(), kInTick);
  if (!running_) return Refusal(name(), "does not run");
  const InTick guard(in_tick_);
  first_command_ = waiting_ = 0;
  fault_.reset();
  Switch(chart_.start, Cause::kReset, kNoEvent);
  return Reached(chart_.start);
}

Result<> Machine::Reached(StateId target) const {
  if (current_ == target) return Ok();
  return Error{kCodeFailed, name() + ": " + Describe(*fault_)};
}

Result<> Machine::Send(EventId event) {
  if (Index(event) >= events_.size()) return Refusal(name(), "has no such event");
  if (events_[Index(event)].urgency == Urgency::kUrgent) {
    counts_.superseded += waiting_;
    waiting_ = 0;
  }
  if (waiting_ == commands_.size()) {
    ++counts_.refused;
    return Error{kCodeFailed, name() + ": " + std::to_string(waiting_) + " commands wait; " +
                                  events_[Index(event)].name + " found no room"};
  }
  commands_[(first_command_ + waiting_) % commands_.size()] = event;
  ++waiting_;
  return Ok();
}

EventId Machine::TakeCommand() {
  if (waiting_ == 0) return kNoEvent;
  const EventId event = commands_[first_command_];
  first_command_ = first_command_ + 1 == commands_.size() ? 0 : first_command_ + 1;
  --waiting_;
  return event;
}

void Machine::Unheeded(EventId command) {
  ++counts_.unheeded;
  TellAll([&](Listener& listener) { listener.OnUnheeded(*this, command, current_); });
}

void Machine::Remember(const Change& change) {
  ++counts_.changes;
  history_.Add(change);
  TellAll([&](Listener& listener) { listener.OnChange(*this, change); });
}

}  // namespace musher::fsm
