#pragma once
// A machine as one plain value: the real controller's Machine, the real ActuatorCores, and the
// messages between them. The search makes one Choice after the other; time is only the order of
// the choices.
//
// What a World keeps beside the controller and its disk:
//   outbox      commands and queries that the controller has not sent yet
//   replies     under way to the controller, in order
//   status_due  the latched status has changed and will be published, with its content by then
//   end         of a process, under way to the controller
//   late        messages that a fault delays: they arrive at any later choice, or never
//
// Time stands still while a message is under way, and then jumps to the next deadline. A callback
// that runs at that moment is overdue, which is a fault; so is a delayed message.
//
// Where the user has rules with a time, it counts, too, as the decision code counts it. Then two
// more choices exist: time passes until just before the next deadline, so that what ends then has
// taken as long as it may (kWait); and a deadline of another actuator passes while a callback,
// whose own time is not over, goes on (kTime with an index). So whatever takes time takes none, or
// all that it has, in every combination.
//
// What is not searched separately, and why nothing is lost by that (actions of A and B commute when
// they share neither a process nor a message):
//   - A command reaches its actuator as soon as it is sent. An event between (a crash, an emergency
//     stop, the end of the controller) commutes with the sending by another process, so it gives
//     the same result before the sending; a command that arrives later is a delayed one.
//   - The end of a callback and the arrival of its reply are one step, as are a status and its
//     arrival, and a crash and its detection: what the controller receives from others in between
//     commutes with what happened at the actuator. Where two messages of one actuator could be
//     reordered, one is delayed. The end of a process that exits by itself is detected later or,
//     before its last reply, at once.
//   - A status that the controller knows already changes nothing and is not waited for. Nor is a
//     status that reports a running command whose reply is awaited and not under way yet, once no
//     fault is left: whatever ends the wait brings a newer report.
//   - The writer of a process whose end was detected is lost with the arrival of its last status.
//   - An emergency stop reaches all actuators at once, also between two commands of one wave; the
//     controller receives it at any time. An actuator that receives it later is another fault.
//   - Before the first request the only fault is an emergency stop: the rest is another start.
//
// Actuators with `host` run on other hosts, whose systemd starts them and reports their exits by
// the link to it. While the link is cut, or the host boots again:
//   - The controller notices it within a time (Link::silent_by), before or after any deadline until
//     then, of all actuators of the host in one step. A link that works again before that has lost
//     or delayed single messages, which are other faults.
//   - Commands are held: each arrives at any time after the link works again, or never. Queries and
//     replies are lost, statuses and stops are latched, exits are reported afterwards.
//   - It works again at any time, or never. Its systemd and the latched statuses are reached then in
//     any order.
//   - Where the controller has ended, neither changes anything that is checked.
//   - It is cut between two commands of one step only before one to that host: it commutes with the
//     others.
//
// The work thread of an actuator with a checkpoint hangs: no callback of it ends until it makes
// progress again, which it may never. Its heartbeats report that.
//
// A battery falls to one of the levels of [policy.battery], and never rises. Its samples go on: the
// three that confirm an empty one come at once, and a controller that takes over receives them.
//
// Of messages to a controller that takes over one order is searched where all lead to the same
// (reduction.hpp).
//
// Actuators are interchangeable where the config stays the same when their names are exchanged: of
// states that differ by their names only one is searched (fingerprint.hpp).

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/lifecycle/config/user_rules.hpp"
#include "musher/lifecycle/machine/timed_rule_check.hpp"
#include "musher/lifecycle/per_actuator.hpp"
#include "musher/search/fake_robot.hpp"

namespace musher::search {

// A node of the search has a bit for each.
inline constexpr std::size_t kMostSearchedActuators = 32;

struct StopMessage {};

using Late = std::variant<Message, event::Replied, event::StatusSeen, StopMessage>;

enum class Work { kNone, kRunning, kOverdue };

// What the systemd of another host is about to report of a process that runs there: the controller
// has started it, or it is found running.
enum class UnitReport : std::uint8_t { kNone, kStarted, kFound };

struct SimActuator : FakeActuator {
  Work work = Work::kNone;
  bool stop_requested = false;  // of the running callback
  bool energised = false;       // its output: on at the end of an upward callback
  bool status_due = false;
  std::int32_t processes = 0;  // also its pid: pids of different actuators are never compared
  std::vector<event::Replied> replies;
  std::optional<bool> end;  // of its process, cleanly or not, on its way to the controller
  std::vector<Late> late;
  bool hung = false;           // its work thread makes no progress
  bool hang_due = false;       // the controller does not know that
  bool backtrace_due = false;  // the controller waits for it
  // On another host.
  UnitReport unit_report = UnitReport::kNone;
  bool wanted = false;           // it is to be started, which was not reported yet
  std::optional<Time> await_by;  // by then it is reported that this waits for its host
  bool killed = false;           // it is, once its host is reached
  bool silent = false;           // it is reported as silent, until a heartbeat arrives
  // For the rules of commands: the highest epoch and numbers so far.
  Epoch epoch = 0;
  CommandNumber begun = 0;    // of a begun callback
  CommandNumber queried = 0;  // of an answered query
  CommandNumber done = 0;     // of a callback that ended with code 0, also of an earlier process
};

struct Request {
  State target;
  int replies = 0;
  bool abandoned = false;  // its controller has ended, which the caller knows
};

// To another host.
struct Link {
  bool cut = false;
  std::optional<Time> silent_by;  // the controller has not noticed the cut yet, but does by then
  int boots = 0;                  // of the host, since the machine started
};

// The same switch, requested again after the release of the stop.
enum class Repeat : std::uint8_t {
  kNotYet,
  kRequested,
  kDone,  // at least degraded; of the present controller
};

struct World : FakeController {
  int faults = 0;  // that may happen in all
  int faults_left = 0;
  PerActuator<SimActuator> actuators;
  std::vector<Message> outbox;
  std::vector<Request> requests;  // request n is the (n-1)th
  State from;                     // where the machine was before the first of them
  bool at_start = false;          // nothing has been requested yet
  bool in_start = false;          // it was started, and nothing is requested
  bool stopped = false;           // an emergency stop has been engaged
  bool stop_seen_due = false;     // the controller has not received it
  bool released = false;          // by a person
  // A supervisor has started the controller after a TearDown, and no person has since.
  bool stays_down = false;
  Repeat repeat = Repeat::kNotYet;
  std::vector<Link> links;                   // to Model::hosts
  std::optional<std::int32_t> battery;       // in percent; none: it is full, and not published
  bool battery_due = false;                  // the controller has received no sample of it
  std::vector<TimedRuleCheck> timed_checks;  // of Model::timed_rules
};

enum class ChoiceKind : std::uint8_t {
  // These are no faults.
  kRequest,       // the first request
  kDeliver,       // the first of the outbox
  kEndOk,         // a callback ends, and its reply arrives
  kEndOnRequest,  // an overdue callback ends because it was requested to stop
  kReply,         // the first of the replies
  kStatus,        // the latched status
  kEnd,           // of a process
  kEndFirst,      // a torn down actuator's process ends, and that is detected before its reply
  kSeeStop,       // the controller receives the emergency stop
  kRelease,       // a person releases it, usually when nothing else is left to happen
  kRepeat,        // and then requests the same switch again
  kTime,          // to the next deadline; `index` 1: only what that is of is overdue
  kWait,          // until just before it
  kLate,          // a delayed message arrives
  kHangReport,    // a controller that takes over notices that an actuator hangs
  kBacktrace,     // of a hung actuator, is taken
  kProgress,      // it makes progress again
  kBattery,       // a controller that takes over receives its sample
  // Events of the link to another host, where the actuator runs.
  kSilence,     // the controller notices that it is cut
  kReach,       // it works again
  kUnitReport,  // systemd reports the actuator's process
  kAwait,       // the actuator's start waits for the host, which is reported
  kHeartbeat,   // heartbeats of the actuator arrive again
  // Each of these is a fault.
  kLose,
  kHold,
  kDuplicate,
  kUnannounced,  // a query of a controller whose announcement it has not received
  kEndFailed,
  kEndTolerated,  // a self-check fails with a code that the config does not list as critical
  kEndReplyLost,
  kEndReplyHeld,
  kEndReplyDuplicated,
  kEndCrash,  // the callback ends, then its process, and that is detected before the reply
  kReplyLost,
  kReplyHeld,
  kReplyDuplicated,
  kStatusLost,
  kStatusHeld,
  kStatusDuplicated,
  kCrash,
  kRestart,        // the controller is killed, and its supervisor starts another
  kStartByPerson,  // the same in a TearDown, by a person, who wants the machine to start
  kRequestError,
  kRequestTearDown,
  kEngageStop,
  kEngageStopLate,  // one actuator receives it late: two faults
  // What another machine sends, or a controller that was replaced, where no identity betrays it.
  kOtherCommand,    // to an actuator, with a higher epoch, unannounced
  kOtherRelease,    // of the emergency stop, to an actuator
  kOtherHeartbeat,  // to the controller, with a lower epoch
  kCutLink,         // to the host of the actuator
  kRebootHost,      // that of the actuator
  kBatteryFalls,    // to the level of `index`: 0 the highest
  kHang,            // the work thread of the actuator
};
static_assert(static_cast<int>(ChoiceKind::kHang) < 64, "Model::faults has a bit for each");

struct Choice {
  ChoiceKind kind = ChoiceKind::kRequest;
  std::uint8_t actuator = 0;
  std::uint8_t index = 0;  // of the delayed message, of the level of the battery, or of kTime
  std::uint8_t cost = 0;   // in faults

  ActuatorIndex which() const { return ActuatorIndex(std::size_t{actuator}); }
};

// The decision code that is searched: the real one, unless a test plants a fault in it.
struct Rules {
  std::function<std::vector<Action>(const MachineConfig&, Machine&, const Event&, Time)>
      controller = [](const auto& config, auto& machine, const auto& event, Time now) {
        return Step(config, machine, event, now);
      };
  std::function<std::vector<ActuatorAction>(const MachineConfig&, ActuatorIndex, ActuatorCore&,
                                            const ActuatorEvent&, Time)>
      actuator = [](const auto& config, ActuatorIndex i, auto& core, const auto& event, Time now) {
        return Step(config, i, core, event, now);
      };
};

inline constexpr std::uint64_t kAllFaults = ~std::uint64_t{0};
// For a search of more faults than of all kinds would end.
constexpr std::uint64_t OnlyFaults(std::initializer_list<ChoiceKind> kinds) {
  std::uint64_t bits = 0;
  for (const ChoiceKind kind : kinds) bits |= std::uint64_t{1} << static_cast<int>(kind);
  return bits;
}

inline constexpr std::size_t kHere = ~std::size_t{0};

struct Model {
  explicit Model(MachineConfig machine, State wanted = {}, Rules decisions = {});

  MachineConfig config;
  State target;  // of the first request
  Rules rules;
  PerActuator<ActuatorIndex> kinds;      // equal for interchangeable actuators
  std::vector<std::string> hosts;        // beside the controller's
  PerActuator<std::size_t> host_of;      // among them; kHere: the controller's
  std::uint64_t faults = kAllFaults;     // the kinds that are choices, a bit for each
  bool releases = false;                 // whether kRelease and kRepeat are choices
  bool releases_early = false;           // whether kRelease is one while anything is under way
  std::vector<StableRule> stable_rules;  // of the user
  std::vector<TimedRule> timed_rules;    // of the user
  bool other_machine = false;            // whether kOtherCommand and what follows it are choices
  bool reduces = true;                   // whether what reduction.hpp says is left out
};

// The results of one choice.
struct Notes {
  bool log = false;                     // whether to fill `scenario`
  std::vector<std::string> scenario;    // in sentences
  std::vector<std::string> violations;  // of the rules
  // The coverage of each rule of the user; null: it is not counted.
  std::vector<RuleCoverage>* rule_coverage = nullptr;
  std::vector<TimedRuleCoverage>* timed_coverage = nullptr;
};

// Whether the actuator is on a host to which the link is cut.
inline bool IsOutOfReach(const Model& model, const World& world, ActuatorIndex i) {
  const std::size_t host = model.host_of[i];
  return host != kHere && world.links[host].cut;
}

// All choices in this state. Faults only while some are left.
std::vector<Choice> Choices(const Model& model, const World& world);

// The levels of the battery in percent, highest first; empty: the config has none.
std::vector<std::int32_t> BatteryLevels(const MachineConfig& config);

// Makes one of the Choices().
void Make(const Model& model, World& world, const Choice& choice, Notes& notes);

// When the callback that runs there is overdue for its controller; none: nothing awaits its end.
std::optional<Time> OverdueAt(const World& world, ActuatorIndex i);

// The last moment before the controller does something by itself, or where it awaits nothing and a
// callback runs, before no more rule with a time is begun. None: there is none after now.
std::optional<Time> EndOfWait(const Model& model, const World& world);

// Whether nothing is left to happen but delayed messages.
bool IsQuiet(const World& world, const std::vector<Choice>& choices);

// A machine before its start, and the start of a machine.
World NewWorld(const Model& model);
void Begin(const Model& model, World& world, bool by_hand, Notes& notes);
// Makes choices without faults until the world is quiet. Returns false when it is not after very
// many of them.
bool RunUntilStable(const Model& model, World& world, Notes& notes);
// A caller requests a switch.
void RequestSwitch(const Model& model, World& world, const State& target, Notes& notes);

}  // namespace musher::search
