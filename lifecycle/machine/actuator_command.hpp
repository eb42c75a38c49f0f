#pragma once
// What a controller commands an actuator: made by the controller's Step(), sent unchanged, and
// checked by the actuator's Step().

#include "musher/base/time.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher {

// "Run the callback of `target`."
struct SwitchCommand {
  Epoch epoch = 0;
  CommandNumber number = 0;
  State target;
  Duration budget{};        // may not begin once it is older than this
  Time status_stamp{};      // the stamp of the last status that its sender had of this actuator,
  Duration since_status{};  // and the time since the sender received it: the command's age
  Incarnation incarnation = 0;  // of the process it is meant for
  bool detached = false;        // for this actuator alone, not to the state of the machine

  friend bool operator==(const SwitchCommand&, const SwitchCommand&) = default;
};

// Queries the outcome of command `number`. The query also fences: a command up to `number` that has
// not begun never will. With `stop` a running callback is requested to stop. Number 0 fences
// nothing: a health probe.
struct QueryCommand {
  Epoch epoch = 0;
  CommandNumber number = 0;
  bool stop = false;

  friend bool operator==(const QueryCommand&, const QueryCommand&) = default;
};

}  // namespace musher
