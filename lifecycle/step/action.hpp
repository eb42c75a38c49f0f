#pragma once
// What the controller has to do: the output of Step() (coordinator.hpp).

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/lifecycle/machine/actuator_command.hpp"
#include "musher/lifecycle/record/record_text.hpp"
#include "musher/lifecycle/step/event.hpp"

namespace musher {

namespace action {

struct SendSwitch {
  ActuatorIndex actuator = 0;
  SwitchCommand command;
  friend bool operator==(const SendSwitch&, const SendSwitch&) = default;
};
struct SendQuery {
  ActuatorIndex actuator = 0;
  QueryCommand command;
  friend bool operator==(const SendQuery&, const SendQuery&) = default;
};
struct StartProcess {
  ActuatorIndex actuator = 0;
  friend bool operator==(const StartProcess&, const StartProcess&) = default;
};
// Find which actuators that have a command run on this host; comes back as ProcessesFound.
struct FindProcesses {
  friend bool operator==(const FindProcesses&, const FindProcesses&) = default;
};
struct SignalProcess {
  ActuatorIndex actuator = 0;
  std::int32_t pid = 0;
  bool kill = false;  // SIGKILL instead of SIGTERM
  friend bool operator==(const SignalProcess&, const SignalProcess&) = default;
};
struct AnswerSetState {
  RequestId request = 0;
  SwitchResult result;
  friend bool operator==(const AnswerSetState&, const AnswerSetState&) = default;
};
// Answers a request that is not a switch.
struct AnswerCall {
  RequestId request = 0;
  Result<> result;
};
// Take a backtrace of a process; the result comes back as BacktraceTaken.
struct TakeBacktrace {
  ActuatorIndex actuator = 0;
  std::int32_t pid = 0;
  friend bool operator==(const TakeBacktrace&, const TakeBacktrace&) = default;
};
// Publish the emergency stop to all actuators, also to those that start later.
struct PublishEmergencyStop {
  EmergencyStop stop;
  bool engaged = false;
  CommandNumber last_command = 0;  // of a release: the last command before it
  friend bool operator==(const PublishEmergencyStop&, const PublishEmergencyStop&) = default;
};
// What has to survive this controller. A save is requested and not waited for; its end comes back
// as SaveEnded with its number. Of each kind only the last save counts.
struct SaveEpoch {
  Epoch epoch = 0;
  SaveNumber save = 0;
  friend bool operator==(const SaveEpoch&, const SaveEpoch&) = default;
};
struct SaveEmergencyStops {
  StoredStops stops;
  SaveNumber save = 0;
  friend bool operator==(const SaveEmergencyStops&, const SaveEmergencyStops&) = default;
};
struct SavePolicy {
  StoredPolicy policy;
  SaveNumber save = 0;
  friend bool operator==(const SavePolicy&, const SavePolicy&) = default;
};
struct SaveStopIntent {
  bool intended = false;  // false: clears the intent
  SaveNumber save = 0;
  friend bool operator==(const SaveStopIntent&, const SaveStopIntent&) = default;
};
struct SaveRemoteActuators {
  std::vector<RemoteActuator> actuators;
  SaveNumber save = 0;
  friend bool operator==(const SaveRemoteActuators&, const SaveRemoteActuators&) = default;
};
struct SaveActuators {
  std::vector<StoredActuator> actuators;
  SaveNumber save = 0;
  friend bool operator==(const SaveActuators&, const SaveActuators&) = default;
};
// Run the command of [policy.power_off] or [policy.reboot], if there is one. The machine is torn
// down, or its time has expired.
struct RunPowerCommand {
  bool reboot = false;
  friend bool operator==(const RunPowerCommand&, const RunPowerCommand&) = default;
};
// The machine-readable part of a record of a switch: it begins, or how it ended.
struct SwitchNote {
  State target;
  std::optional<SwitchOutcome> outcome;  // none: it begins
  State state;                           // of the machine (of the actuator), now
  friend bool operator==(const SwitchNote&, const SwitchNote&) = default;
};
// For the journal and the log. `cause` is the record that this one follows from, so that a chain of
// records explains what was done.
struct Record {
  std::string kind;  // "machine", "switch", "actuator", "process", "policy"
  std::optional<ActuatorIndex> actuator;
  CommandNumber switch_number = 0;
  std::int32_t code = kCodeOk;
  std::string message;
  RecordId id = 0;        // grows from 1 within a Machine; 0: not by the decision code
  RecordId cause = 0;     // id of the record it follows from; 0: none
  State state{};          // the machine's, where this record reports its change
  std::string data = {};  // what does not fit in a line: a backtrace
  std::optional<SwitchNote> of_switch = {};
  EventName event = EventName::kNone;    // what happened, as an id
  std::vector<Argument> arguments = {};  // of the message
  friend bool operator==(const Record&, const Record&) = default;
};
// Start-up is over: the machine is usable, or it failed.
struct StartUpEnded {
  bool usable = false;
  std::string message;
  friend bool operator==(const StartUpEnded&, const StartUpEnded&) = default;
};
// Another controller has taken over; this one has to exit and change nothing more.
struct Fenced {
  std::string message;
  friend bool operator==(const Fenced&, const Fenced&) = default;
};
// The machine is stopped; the controller may end.
struct Stopped {
  friend bool operator==(const Stopped&, const Stopped&) = default;
};

}  // namespace action

using Action =
    std::variant<action::SendSwitch, action::SendQuery, action::StartProcess, action::FindProcesses,
                 action::SignalProcess, action::AnswerSetState, action::AnswerCall,
                 action::TakeBacktrace, action::PublishEmergencyStop, action::SaveEmergencyStops,
                 action::SaveEpoch, action::SavePolicy, action::SaveStopIntent,
                 action::SaveRemoteActuators, action::SaveActuators, action::RunPowerCommand,
                 action::Record, action::StartUpEnded, action::Fenced, action::Stopped>;

}  // namespace musher
