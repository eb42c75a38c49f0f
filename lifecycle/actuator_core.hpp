#pragma once
// The actuator's decision code: which command may run, which is refused and why, and what the
// latched status says. Pure: Step(config, state, event, now) changes the state and gives the
// actions; the shell around it (actuator/) turns DDS samples and the worker thread into events.
//
//            Started                       CallbackEnded ok
//   (new) ────────────▶ busy in SetUp ────────────────────────▶ free ◀───────────────┐
//                            │ failed                            │ command            │
//                            CallbackEnded ▼                                   ▼ │
//                        Finish{code}                          busy ──────────────────┘
//                                                                │ a newer command waits: one
//                                                                place, │ the newest keeps it ▼
//                                              TearDown ended ok: Finish{0}
//
// Rules: the epoch never falls; a number is accepted once and never below one accepted or fenced; a
// command older than its budget by this actuator's clock cannot begin; a callback that runs is
// never interrupted, only asked to stop; a manager without epochs may command as long as no
// controller has spoken, and its command never waits.

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

// "Run the callback of `target`."
struct SwitchCommand {
  std::uint64_t epoch = 0;
  std::uint64_t number = 0;
  State target;
  Duration budget{};        // may not begin once it is older than this
  Time status_stamp{};      // the stamp of the last status its sender had of this actuator,
  Duration since_status{};  // and how long ago the sender had got it: together the command's age
  std::uint64_t incarnation = 0;  // of the process it is meant for

  friend bool operator==(const SwitchCommand&, const SwitchCommand&) = default;
};

// "How did command `number` end?" It also fences: a command up to `number` that has not begun never
// will. With `stop` a running callback is asked to stop.
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
};
struct AskArrived {
  RequestToken token = 0;
  AskCommand command;
};
// A manager that knows no epochs and numbers (CyberDog's FsMachine) wants this state.
struct ManagerCommand {
  RequestToken token = 0;
  State target;
};
struct CallbackEnded {
  std::int32_t code = 0;
  std::string message;
};
}  // namespace actuator_event

using ActuatorEvent =
    std::variant<actuator_event::Started, actuator_event::SwitchArrived, actuator_event::AskArrived,
                 actuator_event::ManagerCommand, actuator_event::CallbackEnded>;

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
                                    actuator_action::Answer, actuator_action::PublishStatus,
                                    actuator_action::BecomeVisible, actuator_action::Finish>;

// The state of one actuator: a plain value.
struct ActuatorCore {
  ActuatorReport report;                  // all but `stamp`, which the shell puts in when it sends
  std::vector<RequestToken> running_for;  // who is told when the running callback ends
  struct Waiting {
    SwitchCommand command;
    std::vector<RequestToken> tokens;
    friend bool operator==(const Waiting&, const Waiting&) = default;
  };
  std::optional<Waiting> waiting;  // the newest command, behind the running callback
  bool unsettled = false;          // the last callback failed: it may have left a state half way

  friend bool operator==(const ActuatorCore&, const ActuatorCore&) = default;
};

// One step of the decision; `config` is the actuator's own table.
std::vector<ActuatorAction> Step(const ActuatorConfig& config, ActuatorCore& core,
                                 const ActuatorEvent& event, Time now);

}  // namespace musher
