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
// Rules: one controller is followed, and it must have announced itself; the epoch never falls; a
// number is accepted once and never below one accepted or fenced; a command older than its budget
// by this actuator's clock cannot begin; a callback that runs is never interrupted, only asked to
// stop; while an emergency stop is latched nothing goes up, not even back to where it is from a way
// down that has failed, and an upward callback that ends meanwhile has failed, whatever it returns:
// its state is not taken and the stop action runs again; what a stop has switched off stays off
// after the release, until a callback of its own state or a higher one ends well without a stop: it
// is held by the stop, and a command to its own state runs the callback; a manager without
// epochs may command as long as no controller has spoken, and its command never waits.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/report.hpp"

namespace musher {

// A request that came over the wire and must be answered exactly once; the shell knows to whom.
using RequestToken = std::uint64_t;

// The participant that something came from, as the transport tells. 0: not known; such a command is
// refused.
using Sender = std::uint64_t;

// "Run the callback of `target`."
struct SwitchCommand {
  std::uint64_t epoch = 0;
  std::uint64_t number = 0;
  State target;
  Duration budget{};        // may not begin once it is older than this
  Time status_stamp{};      // the stamp of the last status its sender had of this actuator,
  Duration since_status{};  // and how long ago the sender had got it: together the command's age
  std::uint64_t incarnation = 0;  // of the process it is meant for
  bool apart = false;             // for this actuator alone, not to where the machine is

  friend bool operator==(const SwitchCommand&, const SwitchCommand&) = default;
};

// "How did command `number` end?" It also fences: a command up to `number` that has not begun never
// will. With `stop` a running callback is asked to stop. Number 0 fences nothing: a health probe.
struct AskCommand {
  std::uint64_t epoch = 0;
  std::uint64_t number = 0;
  bool stop = false;

  friend bool operator==(const AskCommand&, const AskCommand&) = default;
};

namespace actuator_event {
struct Started {};
struct SwitchArrived {
  RequestToken token = 0;
  SwitchCommand command;
  Sender sender = 0;
};
struct AskArrived {
  RequestToken token = 0;
  AskCommand command;
  Sender sender = 0;
};
// A manager that knows no epochs and numbers (CyberDog's FsMachine) wants this state.
struct ManagerCommand {
  RequestToken token = 0;
  State target;
};
struct CallbackEnded {
  std::int32_t code = 0;
  std::string message;
  // Of a self-check that passed although part of the actuator does not work.
  std::int32_t degraded_code = 0;
  std::string degraded_reason = {};
};
// A controller says that it lives.
struct ControllerHeard {
  Sender sender = 0;
  std::uint64_t epoch = 0;
  friend bool operator==(const ControllerHeard&, const ControllerHeard&) = default;
};
// Somebody engages an emergency stop, or the controller releases it.
struct EmergencyStopHeard {
  std::uint64_t id = 0;
  bool engaged = false;
  Sender sender = 0;
  std::string by = {};
  std::string reason = {};
};
// Nothing happened but time.
struct TimePassed {};
}  // namespace actuator_event

using ActuatorEvent = std::variant<actuator_event::Started, actuator_event::SwitchArrived,
                                   actuator_event::AskArrived, actuator_event::ManagerCommand,
                                   actuator_event::CallbackEnded, actuator_event::ControllerHeard,
                                   actuator_event::EmergencyStopHeard, actuator_event::TimePassed>;

namespace actuator_action {
// Run the callback of `target` on the worker; its end comes back as CallbackEnded.
struct RunCallback {
  State target;
  friend bool operator==(const RunCallback&, const RunCallback&) = default;
};
// Ask the running callback to stop.
struct RequestStop {
  friend bool operator==(const RequestStop&, const RequestStop&) = default;
};
// Stop whatever moves, now, whatever else runs.
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
// The actuator is over: torn down (code 0) or not set up (its code).
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

// The state of one actuator: a plain value.
struct ActuatorCore {
  ActuatorReport report;                  // all but `stamp`, which the shell puts in when it sends
  std::vector<RequestToken> running_for;  // who is told when the running callback ends
  bool was_apart = false;                 // before the running callback, should it fail
  struct Waiting {
    SwitchCommand command;
    std::vector<RequestToken> tokens;
    friend bool operator==(const Waiting&, const Waiting&) = default;
  };
  std::optional<Waiting> waiting;  // the newest command, behind the running callback
  bool unsettled = false;          // the last callback failed: it may have left a state half way
  bool half_way_down = false;      // since it was settled, one has failed that led down, or that
                                   // was to switch on again what a stop had switched off
  Sender controller = 0;           // the controller that is followed
  Time controller_heard{};         // its last sign of life
  std::vector<actuator_event::ControllerHeard> announced;  // who says that it is a controller
  std::vector<EmergencyStop> stops;                        // those that are engaged, oldest first
  std::vector<std::uint64_t> released;  // those that are over: what comes of them comes too late
  bool stopped_meanwhile = false;       // an emergency stop was engaged beside the running callback
  bool under_stop = false;              // the same, or the callback began under one

  friend bool operator==(const ActuatorCore&, const ActuatorCore&) = default;
};

// One step of the decision for `config.actuators[index]`.
std::vector<ActuatorAction> Step(const MachineConfig& config, std::size_t index, ActuatorCore& core,
                                 const ActuatorEvent& event, Time now);

// When to step next with TimePassed, unless something else happens before; nullopt: never.
std::optional<Time> NextDeadline(const MachineConfig& config, std::size_t index,
                                 const ActuatorCore& core);

}  // namespace musher
