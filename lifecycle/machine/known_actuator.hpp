#pragma once
// What the controller knows about one actuator. Plain values; only the parts of a step change them.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/lifecycle/event_name.hpp"
#include "musher/lifecycle/field.hpp"
#include "musher/lifecycle/health/health.hpp"
#include "musher/lifecycle/ids.hpp"
#include "musher/lifecycle/machine/report.hpp"

namespace musher {

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
  bool detached = false;
  // How far the actuator's clock was ahead of ours, as known when the command was sent.
  Duration clock_ahead{};

  friend bool operator==(const PendingCommand&, const PendingCommand&) = default;
};

// A command that was superseded before it was answered: the actuator may follow it first.
struct SupersededCommand {
  CommandNumber number = 0;
  State target;

  friend bool operator==(const SupersededCommand&, const SupersededCommand&) = default;
};

// A process that is to end: decided, and not reported as exited yet.
struct Termination {
  std::int32_t pid = 0;
  std::optional<Time> terminate_at;  // SIGTERM; none: not, or sent already
  Time kill_at{};                    // SIGKILL; once sent, its exit is due by then
  bool killed = false;               // SIGKILL was sent
  bool overdue = false;              // nor was its exit seen after that
  bool for_silence = false;          // it alone is silent on its host

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

// The start of the process of an actuator.
enum class Launch {
  kNone,
  kBlocked,       // not started, since an actuator that it needs is degraded
  kUnderWay,      // it is being started, the pid is not known yet
  kFoundRunning,  // a process of this name runs already: wait for it, do not start one
  kAwaitsHost,    // its host is out of reach; it is started there once that is reached
};

// A process that follows the controller of another machine on its host, by its status.
struct TakenProcess {
  std::int32_t pid = 0;
  std::string host;  // its HostId()
  std::string how;   // "it follows another machine now, …"

  friend bool operator==(const TakenProcess&, const TakenProcess&) = default;
};

// What is known about the process of an actuator.
struct ActuatorProcess {
  std::int32_t pid = 0;  // of the process that we started, while it runs; 0: none
  // The HostId() that `pid` belongs to, while it runs on another host; empty: the controller's.
  std::string host;
  Launch launch = Launch::kNone;
  Incarnation dead = 0;                    // the incarnation whose process is known to have exited
  std::optional<Termination> termination;  // none: it may run
  // The last process that has exited before a status of it was received, and its HostId(): the
  // status may arrive late. 0: none.
  std::int32_t ended_pid = 0;
  std::string ended_host;
  std::optional<TakenProcess> taken;  // the last one; see MachineView::IsTaken()

  friend bool operator==(const ActuatorProcess&, const ActuatorProcess&) = default;
};

// The restarts of the process of an actuator.
struct Restarts {
  int count = 0;                    // in a row
  std::optional<Time> at;           // the next one
  std::optional<Time> reset_at;     // present until then: the count is reset
  bool given_up = false;            // restarted too often, or not to be restarted
  bool requested = false;           // by a person: its process has to exit, then it is restarted
  std::vector<RequestId> requests;  // answered when it is back

  friend bool operator==(const Restarts&, const Restarts&) = default;
};

// A failed self-check, which is repeated.
struct FailedChecks {
  int count = 0;           // in a row
  std::optional<Time> at;  // the next one

  friend bool operator==(const FailedChecks&, const FailedChecks&) = default;
};

// Whether this controller controls an actuator.
struct ControlState {
  Incarnation incarnation = 0;  // of the process that TakeControl() was sent to
  std::optional<Time> again;    // it has not answered yet; retry at this time
  // The actuator has a higher epoch: take control then, unless a controller leads with that epoch.
  std::optional<Time> rival_until;

  friend bool operator==(const ControlState&, const ControlState&) = default;
};

struct KnownActuator {
  Presence presence = Presence::kAbsent;
  ActuatorReport report;  // the last one
  // The last report of a process on another host that publishes as this actuator while the known
  // process is present. Its status is latched and may not come again: it counts once the known
  // process is lost.
  std::optional<ActuatorReport> other;
  bool writer_lost = false;  // of its status, since the last report
  // The same instant by the actuator's clock and by ours, from the report with the least latency:
  // the actuator computes the age of a command from it.
  Time clock_theirs{};
  Time clock_ours{};
  ActuatorProcess process;
  Restarts restart;
  ControlState control;
  std::optional<Time> set_up_by;  // not present by then: given up for now
  std::optional<Time> free_by;    // it is busy with a command that no switch waits for
  // In their order, the last to each state; those are over that it has followed or left out.
  std::vector<SupersededCommand> superseded;
  std::optional<Time> exit_by;  // lost, and its process may have exited: known by then

  // How it follows the machine.
  bool checked = false;     // passed its self-check since its process started
  bool join_tried = false;  // the self-check of a late actuator was commanded
  FailedChecks failed_checks;
  bool held = false;       // detached by SetState(actuator, state)
  State kept_in{};         // where it was, or is to be, held: also by a process that is restarted
  bool due = false;        // to be driven to the state of the machine, as soon as it is free
  bool suspended = false;  // an actuator that it is bound to is not up
  // Since the release of the last emergency stop a switch has been requested that leads it up or to
  // a state of the same rank: it may switch on again.
  bool set_again = false;
  // A person has requested its TearDown alone: where its process is lost in that, or is restarted
  // for another actuator, it does not come on again.
  bool down_requested = false;
  // In which its last process was lost: what it had switched on may be on. Until another process of
  // it has reached a state of the machine, or was torn down. May be kUnknownState. "": none.
  State lost_in{};
  bool met = false;  // its process was present, in this run of the controller
  // The process ran before this controller, announced itself after the machine went on, or replaced
  // another process, and was less active than the machine: it stays there until a switch up is
  // requested.
  bool found_below = false;
  std::optional<PendingCommand> command;  // the command under way

  Health health = Health::kWell;
  std::optional<ActuatorFault> fault;  // why it is degraded
  std::optional<Error> tolerated;      // a failure of its last self-check that is not critical
  RecordId cause = 0;  // the record with the reason why it is degraded, lost or back
  // The other host on which the actuator ran, by the last status, which an earlier controller may
  // have received; "" if the protocol does not name the host. None: the actuator is torn down, has
  // exited, or runs here. Stored, because after a reboot of this host the actuator may still run on
  // the other one and be out of reach.
  std::optional<std::string> elsewhere;

  const State& state() const { return report.state; }
  void Supersede() {
    if (!command) return;
    std::erase_if(superseded, [&](const auto& one) { return one.target == command->target; });
    superseded.push_back({command->number, command->target});
    command.reset();
  }
  // To where the commands before the next one lead: those that were superseded, and the one under
  // way. The actuator may follow any of them first. A self-check leads nowhere.
  std::vector<State> BeforeNext() const {
    std::vector<State> targets;
    for (const SupersededCommand& one : superseded) targets.push_back(one.target);
    if (command) targets.push_back(command->target);
    std::erase(targets, kSelfCheck);
    return targets;
  }

  friend bool operator==(const KnownActuator&, const KnownActuator&) = default;
};

// Whether the time for its SetUp is over, and it is not present.
inline bool IsOverdue(const KnownActuator& known, Time now) {
  return known.set_up_by && *known.set_up_by <= now && known.presence != Presence::kPresent;
}

}  // namespace musher

namespace musher::fields {

template <>
inline constexpr std::array<std::string_view, 4> kValueNames<Presence> = {"absent", "starting",
                                                                          "present", "lost"};
static_assert(EndsWith(Presence::kLost));

template <>
inline constexpr std::array<std::string_view, 5> kValueNames<Launch> = {
    "none", "blocked", "under-way", "found-running", "awaits-host"};
static_assert(EndsWith(Launch::kAwaitsHost));

template <>
inline constexpr std::tuple kFields<PendingCommand> = {
    Field{"number", &PendingCommand::number},
    Field{"target", &PendingCommand::target},
    Field{"sent", &PendingCommand::sent},
    Field{"deadline", &PendingCommand::deadline},
    Field{"queries", &PendingCommand::queries},
    Field{"detached", &PendingCommand::detached},
    Field{"clock_ahead", &PendingCommand::clock_ahead},
};

template <>
inline constexpr std::tuple kFields<SupersededCommand> = {
    Field{"number", &SupersededCommand::number},
    Field{"target", &SupersededCommand::target},
};

template <>
inline constexpr std::tuple kFields<Termination> = {
    Field{"pid", &Termination::pid},         Field{"terminate_at", &Termination::terminate_at},
    Field{"kill_at", &Termination::kill_at}, Field{"killed", &Termination::killed},
    Field{"overdue", &Termination::overdue}, Field{"for_silence", &Termination::for_silence},
};

template <>
inline constexpr std::tuple kFields<ActuatorFault> = {
    Field{"code", &ActuatorFault::code},
    Field{"message", &ActuatorFault::message},
    Field{"event", &ActuatorFault::event},
};

template <>
inline constexpr std::tuple kFields<TakenProcess> = {
    Field{"pid", &TakenProcess::pid},
    Field{"host", &TakenProcess::host},
    Field{"how", &TakenProcess::how},
};

template <>
inline constexpr std::tuple kFields<ActuatorProcess> = {
    Field{"pid", &ActuatorProcess::pid},
    Field{"process_host", &ActuatorProcess::host},
    Field{"launch", &ActuatorProcess::launch},
    Field{"dead", &ActuatorProcess::dead},
    Field{"termination", &ActuatorProcess::termination},
    Field{"ended_pid", &ActuatorProcess::ended_pid},
    Field{"ended_host", &ActuatorProcess::ended_host},
    Field{"taken", &ActuatorProcess::taken},
};

template <>
inline constexpr std::tuple kFields<Restarts> = {
    Field{"restarts", &Restarts::count},
    Field{"restart_at", &Restarts::at},
    Field{"reset_at", &Restarts::reset_at},
    Field{"given_up", &Restarts::given_up},
    Field{"restart_requested", &Restarts::requested},
    Field{"restart_requests", &Restarts::requests},
};

template <>
inline constexpr std::tuple kFields<ControlState> = {
    Field{"controlled", &ControlState::incarnation},
    Field{"control_again", &ControlState::again},
    Field{"rival_until", &ControlState::rival_until},
};

template <>
inline constexpr std::tuple kFields<FailedChecks> = {Field{"count", &FailedChecks::count},
                                                     Field{"at", &FailedChecks::at}};

template <>
inline constexpr std::tuple kFields<KnownActuator> = {
    Field{"presence", &KnownActuator::presence},
    Field{"report", &KnownActuator::report},
    Field{"other", &KnownActuator::other},
    Field{"writer_lost", &KnownActuator::writer_lost},
    Field{"clock_theirs", &KnownActuator::clock_theirs},
    Field{"clock_ours", &KnownActuator::clock_ours},
    Part{&KnownActuator::process},
    Part{&KnownActuator::restart},
    Part{&KnownActuator::control},
    Field{"set_up_by", &KnownActuator::set_up_by},
    Field{"checked", &KnownActuator::checked},
    Field{"join_tried", &KnownActuator::join_tried},
    Field{"failed_checks", &KnownActuator::failed_checks},
    Field{"set_again", &KnownActuator::set_again},
    Field{"down_requested", &KnownActuator::down_requested},
    Field{"lost_in", &KnownActuator::lost_in},
    Field{"met", &KnownActuator::met},
    Field{"found_below", &KnownActuator::found_below},
    Field{"held", &KnownActuator::held},
    Field{"kept_in", &KnownActuator::kept_in},
    Field{"due", &KnownActuator::due},
    Field{"fault", &KnownActuator::fault},
    Field{"tolerated", &KnownActuator::tolerated},
    Field{"command", &KnownActuator::command},
    Field{"cause", &KnownActuator::cause},
    Field{"health", &KnownActuator::health},
    Field{"suspended", &KnownActuator::suspended},
    Field{"free_by", &KnownActuator::free_by},
    Field{"superseded", &KnownActuator::superseded},
    Field{"exit_by", &KnownActuator::exit_by},
    Field{"elsewhere", &KnownActuator::elsewhere},
};

}  // namespace musher::fields
