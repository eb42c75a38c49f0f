#pragma once
// The actuator's decision code: which command may run, which is refused and why, and what the
// latched status says. Pure: Step(config, index, core, event, now) changes the core and gives the
// actions; the shell around it (actuator/) turns DDS samples and the worker thread into events.
//
// clang-format off
//           Started                       CallbackEnded ok
//   (new) ───────────▶ busy in SetUp ─────────────────────────▶ free ◀─────────────────┐
//                           │ CallbackEnded                      │ a command, or its   │ CallbackEnded
//                           ▼ failed                             ▼ controller is lost  │
//                      Finish{code}                             busy ──────────────────┘
//                                                                │ a newer command waits: one
//                                                                ▼ place, the newest keeps it
//                                              TearDown ended ok: Finish{0}
// clang-format on
//
// Rules:
//   - One controller has control, and it must have announced itself. The epoch never falls.
//   - A command begins at most once, not after a query of its number, and not after a command or
//     query of a higher one. The number of a command that was refused is used up, too.
//   - A command older than its budget by this actuator's clock cannot begin.
//   - A running callback is never interrupted, only requested to stop.
//   - While an emergency stop is latched, no command goes up, not even to the present state after
//     a downward callback has failed, nor to another state of the same rank above DeActive. An
//     upward callback that ends meanwhile has failed, whatever it returns: its state is not taken,
//     and the stop action runs again.
//   - What a stop has switched off stays off after the release, until a callback that does not
//     lead down succeeds without a stop: until then the actuator is held by the stop, and a
//     command to its present state runs the callback.
//   - A release names the last command that its controller has sent before. No command up to that
//     number switches anything on: it is late, or repeated. A release that a successor repeats
//     names no command: the release may be older than the last requests of the controller before.
//   - An actuator that has lost its controller goes to its safe state by itself. After that no
//     command that was sent before switches anything on: its sender did not know of the change.
//   - With [safety] permit_ms an actuator above DeActive, or on the way there, latches a stop of
//     its own when no permit arrives in time. A permit that is late or repeated, compared with the
//     others of its sender, counts for nothing. In a process that has just started a command waits
//     for the first permit.
//   - TearDown is the last state. After it, another TearDown is done at once, even if that command
//     has waited, and any other command is refused.
//   - A manager without epochs may command until a controller has sent a command or query, and its
//     command never waits.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/actuator_command.hpp"
#include "musher/lifecycle/machine/report.hpp"

namespace musher {

namespace actuator_event {
struct Started {};
struct SwitchArrived {
  RequestToken token = 0;
  SwitchCommand command;
  Sender sender = 0;
};
struct QueryArrived {
  RequestToken token = 0;
  QueryCommand command;
  Sender sender = 0;
};
// A manager without epochs and numbers (CyberDog's FsMachine) commands this state.
struct ManagerCommand {
  RequestToken token = 0;
  State target;
};
struct CallbackEnded {
  std::int32_t code = 0;
  std::string message;
  // Result of a self-check that passed although part of the actuator does not work.
  std::int32_t degraded_code = 0;
  std::string degraded_reason = {};
};
// Outside of a callback: part of the actuator has failed. Code 0: the fault with this reason is
// over.
struct PartFailed {
  std::int32_t code = 0;
  std::string reason;
};
// A heartbeat of a controller.
struct ControllerHeartbeatReceived {
  Sender sender = 0;
  Epoch epoch = 0;
  friend bool operator==(const ControllerHeartbeatReceived&,
                         const ControllerHeartbeatReceived&) = default;
};
// A participant engages an emergency stop, or the controller releases it.
struct EmergencyStopReceived {
  StopId id = 0;
  bool engaged = false;
  Sender sender = 0;
  std::string by = {};
  std::string reason = {};
  CommandNumber last_command = 0;  // of a release: the last command of the controller before it
};
// A permit to move. `stamp`: when it was given, by the clock of its sender. An unknown sender (0)
// permits nothing: its lateness has no measure.
struct PermitReceived {
  Sender sender = 0;
  Time stamp{};
  std::string by = {};
};
// Only time has passed.
struct TimePassed {};
}  // namespace actuator_event

using ActuatorEvent =
    std::variant<actuator_event::Started, actuator_event::SwitchArrived,
                 actuator_event::QueryArrived, actuator_event::ManagerCommand,
                 actuator_event::CallbackEnded, actuator_event::PartFailed,
                 actuator_event::ControllerHeartbeatReceived, actuator_event::EmergencyStopReceived,
                 actuator_event::PermitReceived, actuator_event::TimePassed>;

namespace actuator_action {
// Run the callback of `target` on the worker; its end comes back as CallbackEnded.
struct RunCallback {
  State target;
  friend bool operator==(const RunCallback&, const RunCallback&) = default;
};
// Request the running callback to stop.
struct RequestStop {
  friend bool operator==(const RequestStop&, const RequestStop&) = default;
};
// Stop all motion now, whatever else runs.
struct RunEmergencyStop {
  friend bool operator==(const RunEmergencyStop&, const RunEmergencyStop&) = default;
};
// Answer a request, with the status as it is after this step.
struct Answer {
  RequestToken token = 0;
  Verdict verdict = Verdict::kDone;
  std::int32_t code = 0;
  std::string message;
  friend bool operator==(const Answer&, const Answer&) = default;
};
// The latched status has changed.
struct PublishStatus {
  friend bool operator==(const PublishStatus&, const PublishStatus&) = default;
};
// SetUp is over: services may appear.
struct BecomeVisible {
  friend bool operator==(const BecomeVisible&, const BecomeVisible&) = default;
};
// The actuator has finished: torn down (code 0) or SetUp failed (its code).
struct Finish {
  std::int32_t code = 0;
  std::string message;
  friend bool operator==(const Finish&, const Finish&) = default;
};
}  // namespace actuator_action

using ActuatorAction = std::variant<actuator_action::RunCallback, actuator_action::RequestStop,
                                    actuator_action::RunEmergencyStop, actuator_action::Answer,
                                    actuator_action::PublishStatus, actuator_action::BecomeVisible,
                                    actuator_action::Finish>;

// A sender of permits: the measure for the lateness of its samples.
struct PermitSender {
  Sender sender = 0;
  Duration fastest{};  // from the stamp of a sample to its arrival, between the two clocks
  Time received{};     // its last sample
  friend bool operator==(const PermitSender&, const PermitSender&) = default;
};

// The permit to move that [safety] permit_ms requires.
struct Permit {
  Time until{};                       // the end of the present permit
  Time first_by{};                    // the deadline of the first permit of this process
  std::vector<PermitSender> senders;  // the sender of the last permit is at the end
  Time stamp{};                       // of the sample that counts, by the clock of its sender
  std::string by;                     // the name of its sender
  std::uint64_t stops = 0;            // engaged so far because no permit arrived in time
  friend bool operator==(const Permit&, const Permit&) = default;
};

// An emergency stop that is over. The controller that has released it never engages it again: an
// "engaged" of it that comes later was sent before. Another controller may, which does not know the
// release.
struct ReleasedStop {
  StopId id = 0;
  Sender by = 0;
  friend bool operator==(const ReleasedStop&, const ReleasedStop&) = default;
};

// The state of one actuator: a plain value.
struct ActuatorCore {
  ActuatorReport report;                  // all but `stamp`, which the shell sets when it publishes
  std::vector<RequestToken> running_for;  // answered when the running callback ends
  bool was_detached = false;              // before the running callback; restored if it fails
  struct WaitingCommand {
    SwitchCommand command;
    std::vector<RequestToken> tokens;
    bool stopped = false;  // a stop was engaged meanwhile, or already when it came
    friend bool operator==(const WaitingCommand&, const WaitingCommand&) = default;
  };
  std::optional<WaitingCommand> waiting;  // the newest command, behind the running callback
  bool unsettled = false;                 // the last callback failed: the state may be incomplete
  bool half_way_down = false;        // since the last settled state a callback has failed that led
                                     // down, or that had to switch on again after a stop
  Sender controller = 0;             // the controller that has control
  Time controller_last_heartbeat{};  // its last heartbeat
  Time went_by_itself{};             // when it last set out for its safe state without a command
  std::vector<actuator_event::ControllerHeartbeatReceived>
      announced;                       // the participants that announced themselves as controllers
  std::vector<EmergencyStop> stops;    // the engaged stops, oldest first
  std::vector<ReleasedStop> released;  // later samples of them are ignored
  CommandNumber last_before_release = 0;  // commands up to this one switch nothing on
  bool stopped_meanwhile = false;         // an emergency stop was engaged while the callback ran
  bool under_stop = false;                // the same, or the callback began under one
  Permit permit;

  friend bool operator==(const ActuatorCore&, const ActuatorCore&) = default;
};

// One step of the decision for `config.actuators[index]`.
std::vector<ActuatorAction> Step(const MachineConfig& config, ActuatorIndex index,
                                 ActuatorCore& core, const ActuatorEvent& event, Time now);

// The state whose callback was running when a stop was engaged, still runs, and may switch on what
// the stop action has switched off; empty: there is none. At its end the stop action runs again.
State StillSwitchingOn(const MachineConfig& config, const ActuatorCore& core);

// When to step next with TimePassed, unless another event comes before; nullopt: never.
std::optional<Time> NextDeadline(const MachineConfig& config, ActuatorIndex index,
                                 const ActuatorCore& core);

// Why `command` may not begin at `now`, by the clock of its actuator: it is older than its budget
// (Timeout), or its times are invalid (ParametersInvalid). nullopt: it may begin.
std::optional<Error> CheckAge(const SwitchCommand& command, Time now);

}  // namespace musher
