#pragma once
// The controller's state: the machine, its actuators and the switch under way. Plain values that
// can be copied and compared; only the coordinator (coordinator.hpp) changes them.
//
//   Phase:   idle ──▶ starting ──▶ running ──▶ stopping ──▶ stopped
//                         │  ▲         ▲            ▲
//                         ▼  └ by hand ┘            │
//                       failed ─────────────────────┘
//
// Every phase leads to fenced, once another controller has taken the machine over.

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/field.hpp"
#include "musher/lifecycle/machine/known_actuator.hpp"
#include "musher/lifecycle/machine/policy_state.hpp"
#include "musher/lifecycle/machine/stored.hpp"
#include "musher/lifecycle/machine/switch.hpp"
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

struct StartUpState {
  bool by_hand = false;        // a program drives it (MachineController's calls)
  bool finishing = false;      // a supervisor's start, which finishes the TearDown before it
  bool by_supervisor = false;  // a supervisor starts it, after a crash or a boot of its host
  bool restarted = false;      // the same, and the disk had an epoch
  bool raised = false;         // this controller has raised its epoch, which it may do once
  // The start is not a person's, or has found running processes, or an emergency stop was engaged
  // since.
  bool requests_nothing = false;
  bool set_up = false;              // the actuators of the first stage are present, or given up
  int stage = 0;                    // up to which actuators are started
  std::vector<RequestId> requests;  // answered when all actuators are set up

  friend bool operator==(const StartUpState&, const StartUpState&) = default;
};

// A release that a person has requested, until every actuator has confirmed it.
struct PendingRelease {
  std::vector<RequestId> requests;  // answered at its end
  std::string by;
  StopId last = 0;  // the stop that it publishes last: an actuator that reports it has received all
  Time again{};     // it is published again at this time
  Time until{};     // its end, whether confirmed or not

  friend bool operator==(const PendingRelease&, const PendingRelease&) = default;
};

struct EmergencyStopState {
  std::optional<EmergencyStop> stop;
  RecordId cause = 0;                 // the record of this stop, or of the last one
  std::vector<EmergencyStop> others;  // engaged beside it by other sources, released with it
  std::vector<StopId> released;  // the last released stops, with the ones that newer stops replaced
  std::vector<StopId> replaced;  // of these, the ones that no release has covered since
  std::optional<PendingRelease> release;
  CommandNumber last_before_release = 0;  // the last command before the last release
  bool awaits_request = false;  // since the last stop no switch up was requested for all: on disk
  std::vector<UnreadFolder> unread{};  // whose stops are not known: on disk
  std::uint64_t engagements = 0;       // with this state folder, so far: on disk

  // The first folder in `unread` that no request has answered; null: none.
  const UnreadFolder* Unanswered() const {
    const auto found = std::ranges::find(unread, false, &UnreadFolder::answered);
    return found == unread.end() ? nullptr : &*found;
  }

  friend bool operator==(const EmergencyStopState&, const EmergencyStopState&) = default;
};

struct FallbackState {
  std::optional<State> target;  // on_lost of a critical actuator, when there is time for it
  RecordId cause = 0;           // the record with the reason

  friend bool operator==(const FallbackState&, const FallbackState&) = default;
};

struct SavesState {
  SaveNumber last = 0;
  std::vector<Unsaved> unsaved;           // what is not on disk yet
  std::vector<StoredActuator> actuators;  // as stored last

  friend bool operator==(const SavesState&, const SavesState&) = default;
};

struct Machine {
  Phase phase = Phase::kIdle;
  State state{kUninitialized};
  std::string host;  // of the controller: processes of this host can be watched and signalled
  Epoch epoch = 0;
  CommandNumber number = 0;       // of the last switch or command
  CommandNumber last_switch = 0;  // of the last switch alone
  std::string requested_by;       // of the last switch of the whole machine; "" = its start
  std::optional<StandingRequest> standing;
  StartUpState start_up;
  PerActuator<KnownActuator> actuators;  // in the order of the config
  std::optional<Switch> current;
  std::optional<WaitingSwitch> waiting;  // never together with a current one
  FallbackState fallback;
  std::optional<Shutdown> stopping;
  EmergencyStopState emergency;
  RecordId last_record = 0;  // id of the last record
  State recorded_state;      // the state in the last record of it
  SavesState saves;
  PolicyState policy;

  friend bool operator==(const Machine&, const Machine&) = default;
};

StoredStops StopsOf(const Machine& machine);

// A machine about which nothing is known yet.
Machine MakeMachine(const MachineConfig& config);

// Whether the actuator may not switch on by itself: no switch that leads it up was requested since
// the last emergency stop, which was engaged in this run of the controller, or holds it.
bool MustBeSetAgain(const Machine& machine, const KnownActuator& known);

// The partial fault of a present actuator: the self-check has passed as degraded, or has failed
// with a code that is not critical. The actuator reaches the state of the machine nevertheless.
std::optional<Error> PartialFaultOf(const KnownActuator& known);
// That a second process of the actuator runs on another host, and in which state: this controller
// commands only the one in use.
std::optional<Error> SecondProcessOf(const KnownActuator& known);
// Why the actuator is listed as degraded: its fault, else a second process, else its partial fault.
std::optional<Error> TroubleOf(const KnownActuator& known);

// The names of the actuators that are not in the state of the machine, with a recorded reason, that
// have a partial fault, or of which a second process runs.
std::vector<std::string> Degraded(const MachineConfig& config, const Machine& machine);

}  // namespace musher

namespace musher::fields {

template <>
inline constexpr std::array<std::string_view, 7> kValueNames<Phase> = {
    "idle", "starting", "running", "failed", "stopping", "stopped", "fenced"};
static_assert(EndsWith(Phase::kFenced));

template <>
inline constexpr std::tuple kFields<StartUpState> = {
    Field{"by_hand", &StartUpState::by_hand},
    Field{"finishing", &StartUpState::finishing},
    Field{"restarted", &StartUpState::restarted},
    Field{"raised", &StartUpState::raised},
    Field{"set_up", &StartUpState::set_up},
    Field{"stage", &StartUpState::stage},
    Field{"set_up_requests", &StartUpState::requests},
    Field{"supervised", &StartUpState::requests_nothing},
    Field{"by_supervisor", &StartUpState::by_supervisor},
};

template <>
inline constexpr std::tuple kFields<PendingRelease> = {
    Field{"requests", &PendingRelease::requests}, Field{"by", &PendingRelease::by},
    Field{"last", &PendingRelease::last},         Field{"again", &PendingRelease::again},
    Field{"until", &PendingRelease::until},
};

template <>
inline constexpr std::tuple kFields<EmergencyStopState> = {
    Field{"emergency_stop", &EmergencyStopState::stop},
    Field{"stop_cause", &EmergencyStopState::cause},
    Field{"other_stops", &EmergencyStopState::others},
    Field{"released_stops", &EmergencyStopState::released},
    Field{"release", &EmergencyStopState::release},
    Field{"last_before_release", &EmergencyStopState::last_before_release},
    Field{"awaits_request", &EmergencyStopState::awaits_request},
    Field{"unread_stops", &EmergencyStopState::unread},
    Field{"replaced_stops", &EmergencyStopState::replaced},
    Field{"engagements", &EmergencyStopState::engagements},
};

template <>
inline constexpr std::tuple kFields<FallbackState> = {
    Field{"fallback", &FallbackState::target},
    Field{"fallback_cause", &FallbackState::cause},
};

template <>
inline constexpr std::tuple kFields<SavesState> = {
    Field{"last_save", &SavesState::last},
    Field{"unsaved", &SavesState::unsaved},
    Field{"stored_actuators", &SavesState::actuators},
};

template <>
inline constexpr std::tuple kFields<Machine> = {
    Field{"phase", &Machine::phase},
    Field{"state", &Machine::state},
    Field{"host", &Machine::host},
    Field{"epoch", &Machine::epoch},
    Field{"number", &Machine::number},
    Field{"last_switch", &Machine::last_switch},
    Field{"requested_by", &Machine::requested_by},
    Field{"standing", &Machine::standing},
    Part{&Machine::start_up},
    Field{"actuators", &Machine::actuators},
    Field{"current", &Machine::current},
    Field{"waiting", &Machine::waiting},
    Part{&Machine::fallback},
    Field{"stopping", &Machine::stopping},
    Part{&Machine::emergency},
    Field{"last_record", &Machine::last_record},
    Field{"recorded_state", &Machine::recorded_state},
    Part{&Machine::saves},
    Field{"policy", &Machine::policy},
};

}  // namespace musher::fields
