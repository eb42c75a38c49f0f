#pragma once
// The callbacks of a machine to its listeners: one interface for what it does, another for what
// comes in from outside. A listener cannot break the machine: its exceptions are caught and
// counted, and the only change it can make is to send a command.
//
// Threads: the machine calls its listeners on the thread that calls the machine.

#include <cstdint>
#include <string>
#include <string_view>

#include "musher/base/time.hpp"
#include "musher/behavior/fsm/event.hpp"
#include "musher/behavior/fsm/ids.hpp"

namespace musher::fsm {

enum class Cause : std::uint8_t {
  kStarted,
  kDecided,  // by the state; by a command, if the change names one
  kForced,
  kReset,
  kUnsafe,   // a safety check
  kFault,    // a state failed
  kStopped,  // to no state
};
std::string_view Name(Cause cause);  // "started", "decided", ...

// One change of state.
struct Change {
  Duration at{};           // machine time
  std::uint64_t tick = 0;  // the number of ticks so far; 0: before the first
  StateId from = kNoState;
  StateId to = kNoState;
  EventId command = kNoEvent;
  Cause cause = Cause::kDecided;

  friend bool operator==(const Change&, const Change&) = default;
};

// The function of a state.
enum class Phase : std::uint8_t { kEnter, kRun, kCheck, kTransition, kExit, kSafetyCheck };
std::string_view Name(Phase phase);  // "OnEnter", "Run", ...

struct Fault {
  StateId state = kNoState;
  Phase phase = Phase::kRun;
  Duration at{};
  std::string what;
  // The path of the state, "SHOW/PHOTO". When a machine inside stopped by its own fault, phase and
  // text are of the innermost state.
  std::string where;
};

// An input of a machine from outside. The sequence of these, and the inputs of the states,
// determine its behaviour.
struct Input {
  enum class Kind : std::uint8_t { kStart, kTick, kPause, kCommand, kForce, kReset, kStop };

  Kind kind = Kind::kTick;
  Time time{};                 // of kStart and kTick
  EventId command = kNoEvent;  // of kCommand
  StateId state = kNoState;    // of kStart and kForce
  EventData* data = nullptr;   // of kCommand: what it carries; null: nothing
};

class Machine;

// Not part of Listener: a machine without an input listener calls no listener in each tick.
class InputListener {
 public:
  virtual ~InputListener() = default;
  // Before the input takes effect. Also for a command that will be refused by a full queue; not for
  // a command that a state or a listener sends.
  virtual void OnInput(const Machine& machine, const Input& input) = 0;
};

class Listener {
 public:
  virtual ~Listener() = default;
  // The machine is in its new state; OnEnter of that state follows.
  virtual void OnChange(const Machine& machine, const Change& change);
  // The same in a machine that a state holds, at any depth.
  virtual void OnChangeInside(const Machine& machine, const Machine& inside, const Change& change);
  // A state stays and keeps this command (Next::KeepCommand()): as long as it does, no other
  // command is handled. Once for each command and state.
  virtual void OnKept(const Machine& machine, EventId command, StateId state);
  // A command was not handled in this state.
  virtual void OnUnhandled(const Machine& machine, EventId command, StateId state);
  // Before the machine goes to its safe state or stops.
  virtual void OnFault(const Machine& machine, const Fault& fault);
};

}  // namespace musher::fsm
