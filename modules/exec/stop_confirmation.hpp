#pragma once
// Whether musher-exec has confirmed an emergency stop.
//
// The action of a stop, [emergency_stop] of the file, runs beside the command of a state. The
// command may switch on again what the action has switched off, also if it leads down: Protected is
// entered from below, too. So a stop is confirmed while no command runs, once an action has
// succeeded that began after the last command.
//
//   stop engaged    before a command    while it runs    after it
//   repeated by     the caller          the core         no need
//
// The core of the actuator repeats the action itself at the end of a callback during which a stop
// was engaged (UnderStop() in lifecycle/actuator/actuator_core.cpp). A callback begins in the core
// before its command does, and ends there after it: a stop that comes in between is, for the core,
// one while the callback ran. Before a command it is known as such where the core begins none of
// this kind below a stop. Else, and after a command, the action may run once more than needed.
//
// Threads: one at a time; the caller holds a mutex.

#include <cstdint>
#include <string>

#include "musher/lifecycle/state.hpp"

namespace musher::exec {

// Whether a stop is engaged when a command begins.
enum class StopAtBegin : std::uint8_t {
  kNone,
  kBefore,  // that may have been engaged before the core began the callback
  kSince    // it was engaged since then
};

class StopConfirmation {
 public:
  // `not_ended` is the trouble until an action has ended. Empty: there is nothing to stop.
  explicit StopConfirmation(std::string not_ended);

  // What is not done yet, or could not be done. Empty: an engaged stop is confirmed.
  std::string Trouble() const;

  // The action is to run. Returns the number of this action.
  std::uint64_t BeginAction();
  // `error`: empty if the action has succeeded. Has no effect if another action is awaited.
  void EndAction(std::uint64_t number, const std::string& error);

  // A command begins that may switch on.
  void BeginCommand(const State& state, StopAtBegin stop);
  // Returns whether the caller has to begin the action again, under the same lock.
  // `nothing_left`: the command has ended all that could move. Has no effect if no command runs.
  bool EndCommand(bool nothing_left);

 private:
  void AwaitNextAction();

  const std::string not_ended_;
  std::uint64_t actions_ = 0;       // the number of the last action, or of the awaited one
  std::string action_trouble_;      // of that action
  State command_;                   // the state whose command runs; empty: none
  bool stopped_before_ = false;     // the command began below a stop
  bool stopped_meanwhile_ = false;  // a stop was engaged while the command ran
};

}  // namespace musher::exec
