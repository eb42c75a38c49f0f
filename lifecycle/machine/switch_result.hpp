#pragma once
// How a switch ended, for the machine and for each actuator.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/code.hpp"
#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/lifecycle/field.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher {

// Direction of a switch.
enum class Direction {
  kUp,     // more active: all actuators or none
  kDown,   // less active: as many as can
  kLevel,  // as active as before, or the present state again: as many as can
  kCheck,  // SelfCheck: every actuator is checked
};
std::string_view DirectionName(Direction direction);  // "up", "down", "level", "check"

// What happened to one actuator.
enum class ActuatorOutcome {
  kDone,     // it is in the target state (or has passed its check)
  kRefused,  // it refused; nothing ran
  kFailed,   // its callback ran and gave a code
  kOverdue,  // it missed its deadline; queried, it was still running, or was fenced before it began
  kLost,     // it is not available, or does not answer at all
  kUndone,   // it had switched, or tried to, and is back in its state before
  kSkipped,  // nothing was sent: an actuator that it needs has failed, or any other has before
  kUnsupported,  // it does not list the target; nothing was sent
};
std::string_view OutcomeName(ActuatorOutcome outcome);  // "done", "refused", …

// What happened to the machine.
enum class SwitchOutcome {
  kDone,
  kRefused,       // nothing was sent
  kUndone,        // the machine is in its state before
  kDoneDegraded,  // the machine is in the target state, the degraded actuators are not
  kSuperseded,    // a more urgent switch took over
};
std::string_view OutcomeName(SwitchOutcome outcome);  // "done", …, "done-degraded", "superseded"

struct ActuatorResult {
  std::string name;
  ActuatorOutcome outcome = ActuatorOutcome::kDone;
  std::int32_t code = kCodeOk;
  std::string message;
  Duration duration{};  // from command to outcome; 0 when nothing was sent
  State state;          // the actuator's, now

  friend bool operator==(const ActuatorResult&, const ActuatorResult&) = default;
};

struct SwitchResult {
  CommandNumber number = 0;  // 0: refused before it got a number
  State target;
  std::string actuator;  // empty: the whole machine
  SwitchOutcome outcome = SwitchOutcome::kDone;
  std::int32_t code = kCodeOk;  // 0 exactly for kDone
  std::string reason;           // for kDone: empty, or a side effect: a keep has ended
  State state;                  // of the machine (of the actuator when one was named), now
  std::vector<std::string> degraded;
  std::vector<ActuatorResult> actuators;  // the actuators concerned, in the config's order

  bool done() const { return outcome == SwitchOutcome::kDone; }

  friend bool operator==(const SwitchResult&, const SwitchResult&) = default;
};

// The answer to a request that is refused while the machine, or the one actuator, is in `state`.
// `actuator`: "": of the machine.
SwitchResult RefusedSwitch(const State& target, const std::string& actuator, const State& state,
                           const Error& why);

}  // namespace musher

namespace musher::fields {

template <>
inline constexpr std::array<std::string_view, 4> kValueNames<Direction> = {"up", "down", "level",
                                                                           "check"};
static_assert(EndsWith(Direction::kCheck));

template <>
inline constexpr std::array<std::string_view, 8> kValueNames<ActuatorOutcome> = {
    "done", "refused", "failed", "overdue", "lost", "undone", "skipped", "unsupported"};
static_assert(EndsWith(ActuatorOutcome::kUnsupported));

template <>
inline constexpr std::array<std::string_view, 5> kValueNames<SwitchOutcome> = {
    "done", "refused", "undone", "done-degraded", "superseded"};
static_assert(EndsWith(SwitchOutcome::kSuperseded));

template <>
inline constexpr std::tuple kFields<ActuatorResult> = {
    Field{"name", &ActuatorResult::name},         Field{"outcome", &ActuatorResult::outcome},
    Field{"code", &ActuatorResult::code},         Field{"message", &ActuatorResult::message},
    Field{"duration", &ActuatorResult::duration}, Field{"state", &ActuatorResult::state},
};

template <>
inline constexpr std::tuple kFields<SwitchResult> = {
    Field{"number", &SwitchResult::number},       Field{"target", &SwitchResult::target},
    Field{"actuator", &SwitchResult::actuator},   Field{"outcome", &SwitchResult::outcome},
    Field{"code", &SwitchResult::code},           Field{"reason", &SwitchResult::reason},
    Field{"state", &SwitchResult::state},         Field{"degraded", &SwitchResult::degraded},
    Field{"actuators", &SwitchResult::actuators},
};

}  // namespace musher::fields
