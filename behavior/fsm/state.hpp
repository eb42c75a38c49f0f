#pragma once
// One state of a machine, as a class. Derive from it, keep a reference to the application's data,
// register it with Machine::Add().
//
//   class Idle : public fsm::State {
//    public:
//     explicit Idle(Robot& robot) : robot_(robot) {}
//     void Declare(fsm::Transitions& transitions) override {
//       tracking_ = transitions.To("TRACKING", "a face is seen");
//     }
//     void OnEnter(const fsm::Tick&) override { robot_.pose = "neutral"; }
//     fsm::Next CheckTransition(const fsm::Tick&) override {
//       return robot_.sees_face ? fsm::Next::To(tracking_) : fsm::Next::Stay();
//     }
//    ...
//   };
//
// The calls of a state, one line a tick:
//
//   OnEnter                              the tick in which the last state was left
//   CheckTransition: stay, Run           each tick from then on
//   CheckTransition: to another          decided; in the same tick:
//     Transition -> not done             a gradual one continues in the next tick; no Run
//     Transition -> done, OnExit         and the next state's OnEnter
//
// All of them return at once: they do not sleep, wait, read a clock or lock. The tick has the time.
// An exception leads to the safe state and is reported with the state and the function.
//
// Threads: the machine calls its states on the thread that calls the machine.

#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "musher/base/time.hpp"
#include "musher/behavior/fsm/archive.hpp"
#include "musher/behavior/fsm/chart.hpp"
#include "musher/behavior/fsm/event.hpp"
#include "musher/behavior/fsm/ids.hpp"

namespace musher::fsm {

class Machine;

// The argument of the functions of a state. Times are machine time: the sum of the steps from tick
// to tick, which stands still while the machine is not ticked and never goes back.
struct Tick {
  Duration now{};      // since the machine was started
  Duration step{};     // since the last tick
  Duration elapsed{};  // since this state was entered

  // The oldest queued command, for CheckTransition. That call consumes it: by a transition, by
  // Next::Handle(), or unhandled, which is counted and reported. Next::KeepCommand() keeps it
  // queued, before all others: a state that waits for something else first declares Defer().
  EventId command = kNoEvent;
  // What the command carries; see TypedEvent::In(). Null: nothing.
  const EventData* data = nullptr;

  // For Transition: its target, the time since its begin, and the duration that Next gave.
  StateId target = kNoState;
  Duration transition_elapsed{};
  Duration transition_time{};

  // The completed share of the transition, 0 to 1.
  double progress() const {
    if (transition_elapsed >= transition_time) return 1;
    return static_cast<double>(transition_elapsed.count()) /
           static_cast<double>(transition_time.count());
  }
};

template <class T>
const T* TypedEvent<T>::In(const Tick& tick) const {
  if (id == kNoEvent || tick.command != id) return nullptr;
  return &static_cast<const EventDataOf<T>*>(tick.data)->value;
}

// What CheckTransition decides.
class Next {
 public:
  static Next Stay() { return {kNoState, {}, Use::kUnhandled}; }
  // Stays, and the command of the tick was handled.
  static Next Handle() { return {kNoState, {}, Use::kHandled}; }
  // `gradually`: the duration of the transition; zero: complete in the same tick. To the state
  // itself: it is left and re-entered.
  static Next To(StateId target, Duration gradually = {}) {
    return {target, gradually, Use::kHandled};
  }
  // The same, but not because of the command, which stays queued for the next check. A stay that
  // keeps a command blocks the queue, which is reported (Listener::OnKept()).
  Next KeepCommand() const { return {target_, time_, Use::kKept}; }

  bool stays() const { return target_ == kNoState; }
  bool handles() const { return use_ == Use::kHandled; }
  bool keeps() const { return use_ == Use::kKept || waits(); }
  StateId target() const { return target_; }
  Duration time() const { return time_; }

 private:
  friend class Machine;
  friend class Nested;
  enum class Use : std::uint8_t { kUnhandled, kHandled, kKept, kWaits };  // of the command

  // Stays, and keeps the command until a transition inside has ended.
  static Next Wait() { return {kNoState, {}, Use::kWaits}; }
  bool waits() const { return use_ == Use::kWaits; }

  Next(StateId target, Duration time, Use use) : target_(target), use_(use), time_(time) {}

  StateId target_;
  Use use_;
  Duration time_;
};

// For State::Declare: maps names to ids, and stores the transitions and events of a state.
class Transitions {
 public:
  virtual ~Transitions() = default;

  // Declares a transition, with its condition as text for the graph. An undeclared one is a fault.
  // `state` is searched in this machine, then in the machine around it, and so on; "SHOW/PHOTO" is
  // PHOTO in a machine that SHOW holds; "/SHOW" is searched in the outermost machine only. The
  // returned id is for Next::To() of this state.
  StateId To(std::string_view state, std::string_view when) {
    return To(state, when, Into::kStart);
  }
  // The same, into the history of a state that holds a machine.
  virtual StateId To(std::string_view state, std::string_view when, Into into) = 0;
  // An event that was registered with Machine::AddEvent().
  virtual EventId On(std::string_view event) = 0;
  // The same for an event that carries a T.
  template <class T>
  TypedEvent<T> On(std::string_view event) {
    return {OnType(event, EventTypeOf<T>())};
  }
  // A command that waits while this state is present: it stays queued, and later ones pass it. Of
  // the present states, the innermost that declares something of a command decides: one that
  // declares On() gets it.
  virtual EventId Defer(std::string_view event) = 0;
  // The same as On() for an event that need not be registered.
  virtual std::optional<EventId> Find(std::string_view event) const = 0;
  // Reports an error of this state: Build() fails with it.
  virtual void Refuse(std::string_view why) = 0;

 protected:
  virtual EventId OnType(std::string_view event, const EventType* type) = 0;
};

class State {
 public:
  State() = default;
  virtual ~State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  // Once, when the machine is built: declares its transitions and the events that it handles.
  virtual void Declare(Transitions& transitions);

  virtual void OnEnter(const Tick& tick);
  // Each tick in which the state stays. Not in the tick in which it was entered.
  virtual void Run(const Tick& tick);
  virtual Next CheckTransition(const Tick& tick);
  // Each tick from the one in which the transition was decided, until it returns true (done).
  virtual bool Transition(const Tick& tick);
  // Also when the machine is forced, made safe or stopped; not when OnEnter failed.
  virtual void OnExit(const Tick& tick);

  // Saves and restores what another process needs to continue from here. See archive.hpp.
  virtual void Persist(Archive& archive);

  // The machines inside, of a state that holds any. See nested.hpp.
  virtual std::span<const std::unique_ptr<Machine>> inside();
};

}  // namespace musher::fsm
