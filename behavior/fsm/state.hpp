#pragma once
// One state of a machine, as a class. Derive from it, keep a reference to the application's data,
// register it with Machine::Add().
//
//   class Idle : public fsm::State {
//    public:
//     explicit Idle(Robot& robot) : robot_(robot) {}
//     void Declare(fsm::Ways& ways) override { tracking_ = ways.To("TRACKING", "a face is seen"); }
//     void OnEnter(const fsm::Tick&) override { robot_.pose = "neutral"; }
//     fsm::Next CheckTransition(const fsm::Tick&) override {
//       return robot_.sees_face ? fsm::Next::To(tracking_) : fsm::Next::Stay();
//     }
//    ...
//   };
//
// Its life, one line a tick:
//
//   OnEnter                              the tick in which the last state was left
//   CheckTransition: stay, Run           each tick from then on
//   CheckTransition: to another          decided; in the same tick:
//     Transition -> not done             a gradual one goes on in the next tick; Run rests
//     meanwhile Transition -> done, OnExit         and the next state's OnEnter
//
// All of them come back at once: they do not sleep, wait, read a clock or lock. Time is what the
// tick says. An exception leads to the safe state and is told with the state and the function.

#include <memory>
#include <optional>
#include <string_view>

#include "musher/behavior/fsm/archive.hpp"
#include "musher/behavior/fsm/chart.hpp"
#include "musher/behavior/fsm/ids.hpp"
#include "musher/lifecycle/time.hpp"

namespace musher::fsm {

class Machine;

// What the machine tells a state. Times are machine time: the sum of the steps from tick to tick,
// which stands still while the machine is not ticked and never goes back.
struct Tick {
  Duration now{};      // since the machine was started
  Duration step{};     // since the last tick
  Duration elapsed{};  // since this state was entered

  // The oldest command that waits, for CheckTransition. That call uses it up: by a transition, by
  // Next::Heed(), or else by not heeding it, which is counted and told. Next::KeepCommand() does
  // not.
  EventId command = kNoEvent;

  // For Transition: where it goes, for how long it has gone on, and how long Next said it takes.
  StateId target = kNoState;
  Duration transition_elapsed{};
  Duration transition_time{};

  // Share of the transition that is behind it, 0 to 1.
  double progress() const {
    if (transition_elapsed >= transition_time) return 1;
    return static_cast<double>(transition_elapsed.count()) /
           static_cast<double>(transition_time.count());
  }
};

// What CheckTransition decides.
class Next {
 public:
  static Next Stay() { return {kNoState, {}, Use::kUnhandled}; }
  // Stays, and the command that came with the tick was handled all the same.
  static Next Handle() { return {kNoState, {}, Use::kHandled}; }
  // `gradually`: how long the transition takes; zero: it is complete in the same tick. To the
  // state itself: it is left and entered anew.
  static Next To(StateId target, Duration gradually = {}) {
    return {target, gradually, Use::kHandled};
  }
  // The same, but not because of the command, which goes on to wait for the next check.
  Next KeepCommand() const { return {target_, time_, Use::kKept}; }

  bool stays() const { return target_ == kNoState; }
  bool handles() const { return use_ == Use::kHandled; }
  bool keeps() const { return use_ == Use::kKept; }
  StateId target() const { return target_; }
  Duration time() const { return time_; }

 private:
  enum class Use : std::uint8_t { kUnhandled, kHandled, kKept };  // of the command

  Next(StateId target, Duration time, Use use) : target_(target), use_(use), time_(time) {}

  StateId target_;
  Use use_;
  Duration time_;
};

// For State::Declare: turns names into ids, and remembers what a state may do.
class Ways {
 public:
  virtual ~Ways() = default;

  // A state this one may go to, and when, in words for the drawing. Going anywhere else is a fault.
  virtual StateId To(std::string_view state, std::string_view when) = 0;
  // An event that was registered with Machine::AddEvent().
  virtual EventId On(std::string_view event) = 0;
  // The same of one that need not be there.
  virtual std::optional<EventId> Find(std::string_view event) const = 0;
  // Something is wrong with this state: the machine will not be built, and says so.
  virtual void Refuse(std::string_view why) = 0;
};

class State {
 public:
  State() = default;
  virtual ~State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  // Once, when the machine is built: the states it may go to and the events it handles.
  virtual void Declare(Ways& ways);

  virtual void OnEnter(const Tick& tick);
  // Each tick in which the state stays. Not in the one in which it was entered.
  virtual void Run(const Tick& tick);
  virtual Next CheckTransition(const Tick& tick);
  // Each tick from the one in which the transition was decided, until it says that it is done.
  virtual bool Transition(const Tick& tick);
  // Also when the machine is forced, made safe or stopped; not when OnEnter failed.
  virtual void OnExit(const Tick& tick);

  // What has to be kept to go on from here in another process. See archive.hpp.
  virtual void Persist(Archive& archive);

  // The machine inside, of a state that holds one. See nested.hpp.
  virtual Machine* inside();
};

}  // namespace musher::fsm
