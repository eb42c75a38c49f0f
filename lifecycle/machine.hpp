#pragma once
// What the controller knows: the machine, its actuators and the switch under way. Plain values that
// can be copied and compared; the coordinator (coordinator.hpp) is the only one that changes them.
//
//   Phase:   idle ──▶ starting ──▶ running ──▶ stopping ──▶ stopped
//                         │  ▲         ▲            ▲
//                         ▼  └ by hand ┘            │
//                       failed ─────────────────────┘
//
// From any of them to fenced, when another controller has taken the machine over.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/health.hpp"
#include "musher/lifecycle/plan.hpp"
#include "musher/lifecycle/policy.hpp"
#include "musher/lifecycle/report.hpp"
#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/switch_result.hpp"

namespace musher {

enum class Phase {
  kIdle,      // nothing asked for yet
  kStarting,  // the first stage comes up
  kRunning,   // the machine is usable; later stages may still be loading
  kFailed,    // start-up ended before Active; processes stay for inspection
  kStopping,  // TearDown, then SIGTERM, then SIGKILL
  kStopped,
  kFenced,  // another controller leads the machine now; this one keeps still
};
std::string_view PhaseName(Phase phase);  // "idle", "starting", …

enum class Presence {
  kAbsent,    // not there, and not expected yet
  kStarting,  // its process runs, or it has been heard of, but it has not answered yet
  kPresent,   // it follows this controller
  kLost,      // it was there
};
std::string_view PresenceName(Presence presence);

// One command on its way to one actuator. It ends with a certain outcome: a reply, or, past the
// deadline, the answer to the question how it stands, or nothing at all (lost).
struct Order {
  std::uint64_t number = 0;
  State target;
  Time sent{};
  Time deadline{};  // of the reply; once asked, of the answer
  int asked = 0;    // how often the question was put

  friend bool operator==(const Order&, const Order&) = default;
};

struct ActuatorRecord {
  Presence presence = Presence::kAbsent;
  ActuatorReport report;  // the last one
  // The last report of a process of another host that says it is this actuator, while the present
  // one was there. Its status is latched and may not come again: it counts once that one is lost.
  std::optional<ActuatorReport> other;
  // The same moment by the actuator's clock and by ours, from the report that took least time to
  // come: by it the actuator can tell how old a command is.
  Time clock_theirs{};
  Time clock_ours{};
  std::int32_t process = 0;    // pid of the process we started, while it lives; 0: none
  bool launching = false;      // its process is being started, the pid is not known yet
  std::uint64_t dead = 0;      // the incarnation whose process is known to have ended
  bool blocked = false;        // not started, since one that it needs is degraded
  bool found_running = false;  // a process of this name runs already: wait for it, do not start one
  std::optional<Time> set_up_by;  // not present by then: given up for now
  std::optional<Time> free_by;    // it is busy with what nobody here waits for
  std::uint64_t controlled = 0;   // the incarnation that was asked to follow this controller
  std::optional<Time> take_control_again;  // it has not answered yet; ask again at this time
  bool checked = false;                    // passed its self-check since its process started
  bool join_tried = false;                 // the self-check of a late one was commanded
  bool held = false;                       // set apart by SetState(actuator, state)
  bool due = false;                // to be driven to where the machine is, as soon as it is free
  std::optional<Error> fault;      // why it is degraded
  std::optional<Error> tolerated;  // what its last self-check failed with, and was no critical code
  std::optional<Order> order;      // the command on its way
  std::uint64_t cause = 0;         // the record that says why it is degraded, gone or back

  Health health = Health::kWell;
  int restarts = 0;                // of its process, in a row
  std::optional<Time> restart_at;  // the next one
  std::optional<Time> healthy_at;  // there for so long by then that counting starts anew
  bool given_up = false;           // restarted too often, or not to be restarted
  bool restart_asked = false;      // by a person: its process has to end, then it is started again
  std::vector<std::uint64_t> restart_requests;  // who is told when it is back
  std::int32_t terminating = 0;                 // the process that is about to be killed …
  std::optional<Time> terminate_at;             // … after SIGTERM at this time …
  std::optional<Time> kill_at;                  // … at the latest then
  bool killed = false;                          // it was; by kill_at its end has to be told
  bool parked = false;                          // taken to rest: one that it is bound to is not up
  std::optional<Time>
      outbid_at;  // it follows a higher epoch; claimed then, if nobody leads with it

  const State& state() const { return report.state; }

  friend bool operator==(const ActuatorRecord&, const ActuatorRecord&) = default;
};

// One actuator's part in the switch under way.
struct Leg {
  enum class Progress { kWaiting, kUnderWay, kEnded };

  std::size_t actuator = 0;
  State from;
  State target;
  std::vector<std::size_t> needs;  // actuators whose legs must have ended before
  Progress progress = Progress::kWaiting;
  ActuatorOutcome outcome = ActuatorOutcome::kSkipped;
  bool ran = false;       // its callback may have run, so that it has to be brought back
  bool may_fail = false;  // was degraded before: a failure of it does not undo the others
  std::int32_t code = kCodeOk;
  std::string message;
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
  std::uint64_t number = 0;
  State from;
  State target;
  std::optional<std::size_t> only;  // one actuator instead of the machine
  Direction direction = Direction::kLevel;
  Purpose purpose = Purpose::kRequested;
  std::vector<std::uint64_t> requests;  // who is told
  std::vector<Leg> legs;
  std::vector<ActuatorResult> others;  // those not driven and why
  bool stopped = false;                // by an emergency stop: on the way up it has failed
  bool rolling_back = false;
  std::uint64_t back_number = 0;  // of the commands of the rollback
  std::vector<Leg> back;          // the legs of the rollback
  std::uint64_t cause = 0;        // the record that says why there is this switch

  friend bool operator==(const Switch&, const Switch&) = default;
};

// What is meant to follow a TearDown of the machine.
enum class AfterTearDown {
  kStaysDown,    // until a person starts it
  kMayStart,     // a supervisor ends it, and may start it whenever it likes once it is down
  kStartsAgain,  // the same controller starts it again, from another slot
};

// A switch that was requested while an actuator was on its own way to where the machine is. Nothing
// has been sent for it; no other actuator begins such a way before it.
struct WaitingSwitch {
  State target;
  std::optional<std::size_t> only;
  Time until{};                         // then it is begun or refused
  std::vector<std::uint64_t> requests;  // who is told
  std::uint64_t cause = 0;              // the record of the request

  friend bool operator==(const WaitingSwitch&, const WaitingSwitch&) = default;
};

// The end of the machine: when to get harder.
struct Stopping {
  Time begun{};
  Time tear_down_by{};               // TearDown has to be over
  std::optional<Time> terminate_at;  // SIGTERM to what is left
  Time kill_at{};                    // SIGKILL
  Time give_up_at{};                 // the budget is over
  bool terminated = false;
  bool killed = false;
  enum class Look { kNotYet, kUnderWay, kDone };
  Look look = Look::kNotYet;  // for processes that nothing is known of, at the end
  AfterTearDown after = AfterTearDown::kStaysDown;
  std::optional<Time> intent_by;  // TearDown waits until its intent is on disk, at most to then
  std::optional<SwitchResult> result;  // of TearDown, told when the processes are gone
  std::vector<std::uint64_t> requests;

  friend bool operator==(const Stopping&, const Stopping&) = default;
};

// The emergency stops as the next controller has to know them.
struct StoredStops {
  std::vector<EmergencyStop> engaged;   // oldest first
  std::vector<std::uint64_t> released;  // ids, the last one at the end

  friend bool operator==(const StoredStops&, const StoredStops&) = default;
};

// What is on disk, and what was received of other controllers and panels since. What either of them
// has released is over.
StoredStops Merge(const StoredStops& stored, const StoredStops& received);

// What of a controller is on disk, for the next one.
enum class Stored {
  kEpoch,
  kEmergencyStops,
  kPolicy,
  kStopIntent,  // the machine is to be torn down and to stay so
};
std::string_view StoredName(Stored what);  // "epoch", "emergency stop", …

// Something that was handed to the disk and is not known to be there.
struct Unsaved {
  Stored what = Stored::kEpoch;
  std::uint64_t save = 0;  // the last save of it
  Time since{};            // of the first one that is not there
  std::string why;         // it has failed; empty: not ended yet

  friend bool operator==(const Unsaved&, const Unsaved&) = default;
};

struct Machine {
  Phase phase = Phase::kIdle;
  bool by_hand = false;    // a program drives the start-up itself (MachineController's calls)
  bool finishing = false;  // a supervisor's start, which ends the TearDown of the controller before
  State state{kUninitialized};
  std::string host;  // of the controller: processes of this host can be watched and signalled
  std::uint64_t epoch = 0;
  std::uint64_t number = 0;       // of the last switch or command
  std::uint64_t last_switch = 0;  // of the last switch alone
  bool set_up = false;            // those waited for at the start have come, or are given up
  int stage = 0;                  // up to which actuators are started
  std::vector<ActuatorRecord> actuators;  // in the order of the config
  std::optional<Switch> current;
  std::optional<WaitingSwitch> waiting;  // never beside a current one
  std::optional<State> fallback;     // on_lost of a critical actuator, when there is time for it
  std::uint64_t fallback_cause = 0;  // the record that says why
  std::optional<Stopping> stopping;
  std::optional<EmergencyStop> emergency_stop;
  std::uint64_t stop_cause = 0;                // the record that tells of it
  std::vector<EmergencyStop> other_stops;      // engaged beside it, released with it
  std::vector<std::uint64_t> released_stops;   // the last ones that were released
  std::vector<std::uint64_t> set_up_requests;  // who waits for all actuators to be set up
  std::uint64_t last_record = 0;               // id of the last record
  State told_state;                            // the last one that a record told
  std::uint64_t last_save = 0;                 // number of the last save
  std::vector<Unsaved> unsaved;                // what is not on disk yet
  PolicyState policy;

  friend bool operator==(const Machine&, const Machine&) = default;
};

// A machine of which nothing is known yet.
Machine MakeMachine(const MachineConfig& config);

// What does not work of one that is there, and is no reason for it not to be where the machine is:
// its self-check has passed with that, or has failed with a code that is not critical.
std::optional<Error> PartialFaultOf(const ActuatorRecord& record);
// Its fault, else its partial one: why it is listed as degraded.
std::optional<Error> TroubleOf(const ActuatorRecord& record);

// The names of those that are not where the machine is, with a reason on record, or of which part
// does not work.
std::vector<std::string> Degraded(const MachineConfig& config, const Machine& machine);

}  // namespace musher
