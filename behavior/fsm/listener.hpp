#pragma once
// What a machine tells those who watch it. A listener cannot break the machine: what it throws is
// caught and counted, and it can do no more to it than send it a command.

#include <cstdint>
#include <string>
#include <string_view>

#include "musher/behavior/fsm/ids.hpp"
#include "musher/lifecycle/time.hpp"

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
  std::uint64_t tick = 0;  // of how many; 0: before the first
  StateId from = kNoState;
  StateId to = kNoState;
  EventId command = kNoEvent;
  Cause cause = Cause::kDecided;

  friend bool operator==(const Change&, const Change&) = default;
};

// In which function of a state.
enum class Phase : std::uint8_t { kEnter, kRun, kCheck, kTransition, kExit, kSafetyCheck };
std::string_view Name(Phase phase);  // "OnEnter", "Run", ...

struct Fault {
  StateId state = kNoState;
  Phase phase = Phase::kRun;
  Duration at{};
  std::string what;
  // The path of the state, "SHOW/PHOTO". Phase and words are those of the innermost state, when a
  // machine inside stopped by a fault of its own.
  std::string where;
};

// What comes into a machine from outside. What the states are given and these, in their order,
// decide all that it does.
struct Input {
  enum class Kind : std::uint8_t { kStart, kTick, kPause, kCommand, kForce, kReset, kStop };

  Kind kind = Kind::kTick;
  Time time{};                 // of kStart and kTick
  EventId command = kNoEvent;  // of kCommand
  StateId state = kNoState;    // of kStart and kForce
};

class Machine;

class Listener {
 public:
  virtual ~Listener() = default;
  // Before it takes effect. Of commands, also of one that will find no room; not of one that a
  // state or a listener sends.
  virtual void OnInput(const Machine& /*machine*/, const Input& /*input*/) {}
  // The machine is in its new state, whose OnEnter comes next.
  virtual void OnChange(const Machine& /*machine*/, const Change& /*change*/) {}
  // A command came to nothing in this state.
  virtual void OnUnhandled(const Machine& /*machine*/, EventId /*command*/, StateId /*state*/) {}
  // Before the machine goes to its safe state or stops.
  virtual void OnFault(const Machine& /*machine*/, const Fault& /*fault*/) {}
};

}  // namespace musher::fsm
