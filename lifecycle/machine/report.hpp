#pragma once
// What an actuator reports about itself: the latched status of the wire as a plain value.

#include <cstdint>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/lifecycle/field.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher {

// The fault of an actuator that sends nothing any more, until more is known about it. Its process
// may have exited, or may only be out of reach: of another host, behind a cable that is cut, or
// stopped.
inline constexpr const char* kOutOfReach = "connection lost";

// Epochs grow by one with every controller, numbers with every command; values from these on are
// not taken over from a report. A controller's own commands may continue the number beyond.
inline constexpr Epoch kLastEpoch{std::uint64_t{1} << 62};
inline constexpr CommandNumber kLastNumber{std::uint64_t{1} << 62};

// Stops the robot until a person releases it. Several engaged at once count as one.
struct EmergencyStop {
  StopId id = 0;  // random, from the participant that engaged it
  std::string by;
  std::string reason;

  friend bool operator==(const EmergencyStop&, const EmergencyStop&) = default;
};

// " by alice (smoke)": what is known of it, behind "an emergency stop is engaged".
inline std::string OriginOf(const EmergencyStop& stop) {
  return (stop.by.empty() ? "" : " by " + stop.by) +
         (stop.reason.empty() ? "" : " (" + stop.reason + ")");
}

struct ActuatorReport {
  State state{kUninitialized};
  State target;                   // its callback runs for this state; empty when it is free
  CommandNumber busy_number = 0;  // the command that runs; 0 when free or in its own SetUp
  Epoch epoch = 0;                // highest controller epoch seen
  CommandNumber number = 0;       // highest of a command received, also a refused one, or a query
  CommandNumber outcome_number = 0;  // the last command that ended, its code and message
  std::int32_t outcome_code = 0;
  std::string outcome_message;
  Incarnation incarnation = 0;  // of its process: grows with every start on a host
  std::int32_t pid = 0;
  std::string host;
  std::string config_hash;
  // Detached: its state, or the one it is switching to, was set for it alone and is independent of
  // the machine's state.
  bool detached = false;
  StopId emergency_stop = 0;  // the stop that it has latched; 0: none
  // A stop has switched off what its state had switched on, and since then no callback has
  // succeeded without a stop, except for callbacks that lead down. It outlasts the release.
  bool held_by_stop = false;
  // Its last self-check passed as degraded: part of it does not work. The code and the reason; 0:
  // all works.
  std::int32_t degraded_code = 0;
  std::string degraded_reason;
  // Participant and reason of `emergency_stop`, as it was engaged; empty where unknown.
  std::string emergency_stop_by;
  std::string emergency_stop_reason;
  // The stops that it has latched beside `emergency_stop`, oldest first.
  std::vector<StopId> other_stops;
  // The stop of the last release that it has received from its controller; 0: none.
  StopId released_stop = 0;
  Time stamp{};  // by the actuator's own clock

  bool busy() const { return !target.empty(); }

  friend bool operator==(const ActuatorReport&, const ActuatorReport&) = default;
};

// How an actuator answered a command.
enum class Verdict {
  kDone,
  kRefused,  // nothing ran
  kFailed,   // the callback ran and gave a code
};

}  // namespace musher

namespace musher::fields {

template <>
inline constexpr std::array<std::string_view, 3> kValueNames<Verdict> = {"done", "refused",
                                                                         "failed"};
static_assert(EndsWith(Verdict::kFailed));

template <>
inline constexpr std::tuple kFields<ActuatorReport> = {
    Field{"state", &ActuatorReport::state},
    Field{"target", &ActuatorReport::target},
    Field{"busy_number", &ActuatorReport::busy_number},
    Field{"epoch", &ActuatorReport::epoch},
    Field{"number", &ActuatorReport::number},
    Field{"outcome_number", &ActuatorReport::outcome_number},
    Field{"outcome_code", &ActuatorReport::outcome_code},
    Field{"outcome_message", &ActuatorReport::outcome_message},
    Field{"incarnation", &ActuatorReport::incarnation},
    Field{"pid", &ActuatorReport::pid},
    Field{"host", &ActuatorReport::host},
    Field{"config_hash", &ActuatorReport::config_hash},
    Field{"detached", &ActuatorReport::detached},
    Field{"emergency_stop", &ActuatorReport::emergency_stop},
    Field{"held_by_stop", &ActuatorReport::held_by_stop},
    Field{"degraded_code", &ActuatorReport::degraded_code},
    Field{"degraded_reason", &ActuatorReport::degraded_reason},
    Field{"emergency_stop_by", &ActuatorReport::emergency_stop_by},
    Field{"emergency_stop_reason", &ActuatorReport::emergency_stop_reason},
    Field{"released_stop", &ActuatorReport::released_stop},
    Field{"other_stops", &ActuatorReport::other_stops},
    Field{"stamp", &ActuatorReport::stamp},
};

template <>
inline constexpr std::tuple kFields<EmergencyStop> = {
    Field{"id", &EmergencyStop::id},
    Field{"by", &EmergencyStop::by},
    Field{"reason", &EmergencyStop::reason},
};

}  // namespace musher::fields
