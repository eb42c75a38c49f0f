#pragma once
// The controller's state: the machine, its actuators and the switch under way. Plain values that
// can be copied and compared; only the coordinator (coordinator.hpp) changes them.
//
//   Phase:   idle ──▶ starting ──▶ running ──▶ stopping ──▶ stopped
//                         │  ▲         ▲            ▲
//                         ▼  └ by hand ┘            │
//                       failed ─────────────────────┘
//
// From each of them to fenced, when another controller has taken the machine over.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/event_name.hpp"
#include "musher/lifecycle/health/health.hpp"
#include "musher/lifecycle/machine/policy_state.hpp"
#include "musher/lifecycle/machine/report.hpp"
#include "musher/lifecycle/machine/switch_result.hpp"
#include "musher/lifecycle/per_actuator.hpp"

namespace musher {

enum class Phase {
  kIdle,      // not started yet
  kStarting,  // the first stage comes up
  kRunning,   // the machine is usable; later stages may still be loading
  kFailed,    // start-up ended before Active; processes stay for inspection
  kStopping,  // TearDown, then SIGTERM, then SIGKILL
  kStopped,
  kFenced,  // another controller leads the machine now; this one changes nothing more
};
std::string_view PhaseName(Phase phase);  // "idle", "starting", …

enum class Presence {
  kAbsent,    // not available, and not expected yet
  kStarting,  // its process runs, or its status was received, but it has not answered yet
  kPresent,   // controlled by this controller
  kLost,      // it was present
};
std::string_view PresenceName(Presence presence);

// One command under way to one actuator. It ends with a definite outcome: a reply, or, past the
// deadline, the answer to the query for its outcome, or no answer at all (lost).
struct PendingCommand {
  CommandNumber number = 0;
  State target;
  Time sent{};
  Time deadline{};  // of the reply; once queried, of the answer
  int queries = 0;  // how often the outcome was queried

  friend bool operator==(const PendingCommand&, const PendingCommand&) = default;
};

// A process that is to end: decided, and not reported as exited yet.
struct Termination {
  std::int32_t pid = 0;
  std::optional<Time> terminate_at;  // SIGTERM; none: not, or sent already
  Time kill_at{};                    // SIGKILL; once sent, its exit is due by then
  bool killed = false;               // SIGKILL was sent

  friend bool operator==(const Termination&, const Termination&) = default;
};

// Why an actuator is degraded. For people it is the error; decisions compare the event.
struct ActuatorFault {
  std::int32_t code = kCodeFailed;
  std::string message;
  EventName event = EventName::kNone;

  operator Error() const { return {code, message}; }  // NOLINT(google-explicit-constructor)
  friend bool operator==(const ActuatorFault&, const ActuatorFault&) = default;
};

struct ActuatorRecord {
  Presence presence = Presence::kAbsent;
  ActuatorReport report;  // the last one
  // The last report of a process on another host that publishes as this actuator while the known
  // process is present. Its status is latched and may not come again: it counts once the known
  // process is lost.
  std::optional<ActuatorReport> other;
  // The same instant by the actuator's clock and by ours, from the report with the least latency:
  // the actuator computes the age of a command from it.
  Time clock_theirs{};
  Time clock_ours{};
  std::int32_t process = 0;    // pid of the process we started, while it runs; 0: none
  bool launching = false;      // its process is being started, the pid is not known yet
  Incarnation dead = 0;        // the incarnation whose process is known to have exited
  bool blocked = false;        // not started, since an actuator that it needs is degraded
  bool found_running = false;  // a process of this name runs already: wait for it, do not start one
  std::optional<Time> set_up_by;           // not present by then: given up for now
  std::optional<Time> free_by;             // it is busy with a command that no switch waits for
  Incarnation controlled = 0;              // the incarnation that TakeControl() was sent to
  std::optional<Time> take_control_again;  // it has not answered yet; retry at this time
  bool checked = false;                    // passed its self-check since its process started
  bool join_tried = false;                 // the self-check of a late actuator was commanded
  bool held = false;                       // detached by SetState(actuator, state)
  bool due = false;  // to be driven to the state of the machine, as soon as it is free
  // Since the release of the last emergency stop a switch has been requested that leads it up or to
  // a state of the same rank: it may switch on again.
  bool set_again = false;
  std::optional<ActuatorFault> fault;     // why it is degraded
  std::optional<Error> tolerated;         // a failure of its last self-check that is not critical
  std::optional<PendingCommand> command;  // the command under way
  RecordId cause = 0;  // the record with the reason why it is degraded, lost or back

  Health health = Health::kWell;
  int restarts = 0;                // of its process, in a row
  std::optional<Time> restart_at;  // the next one
  std::optional<Time> healthy_at;  // present until then: the count is reset
  bool given_up = false;           // restarted too often, or not to be restarted
  bool restart_requested = false;  // by a person: its process has to exit, then it is restarted
  std::vector<RequestId> restart_requests;  // answered when it is back
  std::optional<Termination> termination;   // of its process; none: it may run
  bool suspended = false;                   // an actuator that it is bound to is not up
  // It has a higher epoch: take control at this time, if no controller leads with that epoch.
  std::optional<Time> outbid_at;
  // The other host on which it ran by its last status, also when an earlier controller received
  // that; "" if its protocol does not name the host. None: it is torn down, has exited, or runs
  // here. Stored: after a reboot of this host it may still run there and be out of reach.
  std::optional<std::string> elsewhere;

  const State& state() const { return report.state; }

  friend bool operator==(const ActuatorRecord&, const ActuatorRecord&) = default;
};

// One actuator's part in the switch under way.
struct Leg {
  enum class Progress { kWaiting, kUnderWay, kEnded };

  ActuatorIndex actuator = 0;
  State from;
  State target;
  std::vector<ActuatorIndex> needs;  // actuators whose legs must have ended before
  Progress progress = Progress::kWaiting;
  ActuatorOutcome outcome = ActuatorOutcome::kSkipped;
  bool ran = false;       // its callback may have run, so that it has to be rolled back
  bool may_fail = false;  // was degraded before, or is skipped: does not undo the others
  std::int32_t code = kCodeOk;
  std::string message;
  EventName event = EventName::kNone;  // of the message
  Time started{};
  Duration duration{};

  bool failed() const { return progress == Progress::kEnded && outcome != ActuatorOutcome::kDone; }

  friend bool operator==(const Leg&, const Leg&) = default;
};

enum class Purpose {
  kRequested,        // by a person or an application
  kStartUpCheck,     // the self-check of the first stage
  kStartUpActivate,  // the first stage to Active
  kFallback,         // to on_lost of a critical actuator
  kStop,             // TearDown
  kPolicy,           // by a rule: the battery, or lying still
};

struct Switch {
  CommandNumber number = 0;
  State from;
  State target;
  std::optional<ActuatorIndex> only;  // one actuator instead of the machine
  Direction direction = Direction::kLevel;
  Purpose purpose = Purpose::kRequested;
  std::vector<RequestId> requests;  // answered at its end
  std::vector<Leg> legs;
  std::vector<ActuatorResult> others;  // the actuators not driven, and why
  bool stopped = false;                // by an emergency stop
  bool rolling_back = false;
  CommandNumber back_number = 0;  // of the commands of the rollback
  std::vector<Leg> back;          // the legs of the rollback
  RecordId cause = 0;             // the record with the reason for this switch

  friend bool operator==(const Switch&, const Switch&) = default;
};

// What follows a TearDown of the machine.
enum class AfterTearDown {
  kStaysDown,    // until a person starts it
  kMayStart,     // a supervisor ends it, and may start it at any time once it is down
  kStartsAgain,  // the same controller starts it again, from another slot
};

// A switch that was requested while an actuator was being driven to the state of the machine on its
// own. Nothing has been sent for it; no other actuator is driven on its own before it.
struct WaitingSwitch {
  State target;
  std::optional<ActuatorIndex> only;
  Time until{};                     // then it begins or is refused
  std::vector<RequestId> requests;  // answered at its end
  RecordId cause = 0;               // the record of the request

  friend bool operator==(const WaitingSwitch&, const WaitingSwitch&) = default;
};

// The end of the machine: when to escalate.
struct Stopping {
  Time begun{};
  Time tear_down_by{};               // the deadline of TearDown
  std::optional<Time> terminate_at;  // SIGTERM to what is left
  Time kill_at{};                    // SIGKILL
  Time give_up_at{};                 // the end of the budget
  bool terminated = false;
  bool killed = false;
  enum class Look { kNotYet, kUnderWay, kDone };
  Look look = Look::kNotYet;  // for unknown processes, at the end
  AfterTearDown after = AfterTearDown::kStaysDown;
  std::optional<Time> intent_by;  // TearDown waits until its intent is on disk, at most until then
  std::optional<SwitchResult> result;  // of TearDown, answered when the processes have exited
  std::vector<RequestId> requests;

  friend bool operator==(const Stopping&, const Stopping&) = default;
};

struct Machine;

// The emergency stops that are stored for the next controller.
struct StoredStops {
  std::vector<EmergencyStop> engaged;  // oldest first
  std::vector<StopId> released;        // ids, the last one at the end

  friend bool operator==(const StoredStops&, const StoredStops&) = default;
};

// Merges what is on disk with what was received from other controllers and panels since. A stop
// that is released in either of them is over.
StoredStops Merge(const StoredStops& stored, const StoredStops& received);
StoredStops StopsOf(const Machine& machine);

// An actuator that runs on another host, as it is stored for the next controller.
struct RemoteActuator {
  std::string name;
  std::string host;  // "": not known

  friend bool operator==(const RemoteActuator&, const RemoteActuator&) = default;
};

// What a controller stores on disk for the next one.
enum class Stored {
  kEpoch,
  kEmergencyStops,
  kPolicy,
  kStopIntent,  // the machine is to be torn down and to stay down
  kRemoteActuators,
};
std::string_view StoredName(Stored what);  // "epoch", "emergency stop", …

// Data that was handed to the disk thread and is not known to be saved.
struct Unsaved {
  Stored what = Stored::kEpoch;
  SaveNumber save = 0;  // the last save of it
  Time since{};         // of the first save that is not on disk
  std::string why;      // of a failure; empty: not ended yet

  friend bool operator==(const Unsaved&, const Unsaved&) = default;
};

struct Machine {
  Phase phase = Phase::kIdle;
  bool by_hand = false;    // a program drives the start-up itself (MachineController's calls)
  bool finishing = false;  // a supervisor's start, which finishes the TearDown before it
  State state{kUninitialized};
  std::string host;  // of the controller: processes of this host can be watched and signalled
  Epoch epoch = 0;
  CommandNumber number = 0;       // of the last switch or command
  CommandNumber last_switch = 0;  // of the last switch alone
  bool set_up = false;            // the actuators of the first stage are present, or given up
  int stage = 0;                  // up to which actuators are started
  PerActuator<ActuatorRecord> actuators;  // in the order of the config
  std::optional<Switch> current;
  std::optional<WaitingSwitch> waiting;  // never together with a current one
  std::optional<State> fallback;  // on_lost of a critical actuator, when there is time for it
  RecordId fallback_cause = 0;    // the record with the reason
  std::optional<Stopping> stopping;
  std::optional<EmergencyStop> emergency_stop;
  RecordId stop_cause = 0;                 // the record of it
  std::vector<EmergencyStop> other_stops;  // engaged beside it, released with it
  std::vector<StopId> released_stops;      // the stops released last
  std::vector<RequestId> set_up_requests;  // answered when all actuators are set up
  RecordId last_record = 0;                // id of the last record
  State recorded_state;                    // the last one that was recorded
  SaveNumber last_save = 0;                // number of the last save
  std::vector<Unsaved> unsaved;            // what is not on disk yet
  PolicyState policy;

  friend bool operator==(const Machine&, const Machine&) = default;
};

// A machine about which nothing is known yet.
Machine MakeMachine(const MachineConfig& config);

// The partial fault of a present actuator that does not keep it from the state of the machine: its
// self-check has passed as degraded, or has failed with a code that is not critical.
std::optional<Error> PartialFaultOf(const ActuatorRecord& record);
// Its fault, else its partial one: why it is listed as degraded.
std::optional<Error> TroubleOf(const ActuatorRecord& record);

// The names of the actuators that are not in the state of the machine, with a recorded reason, or
// that have a partial fault.
std::vector<std::string> Degraded(const MachineConfig& config, const Machine& machine);

}  // namespace musher
