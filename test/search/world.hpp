#pragma once
// A small machine as one plain value: the real controller's Machine, three real ActuatorCores, and
// what is between them. Whoever searches makes one Choice after the other; the order of choices is
// all that there is of time.
//
// What a World keeps apart from the two decision codes:
//   outbox      commands and questions that the controller has not put on the wire yet
//   replies     on their way to the controller, in order
//   status_due  the latch has changed and is to be told; what is told is how it stands by then
//   end         of a process, on its way to the controller
//   late        messages that a fault holds back: they come whenever the search likes, or never
//
// Time stands still while anything is on its way, and then jumps to the next deadline. A callback
// that runs when it does is overdue, which is a fault; so is a message that is held back.
//
// What is not told apart, and why nothing is lost by that (what A and B do commutes when they share
// neither a process nor a message):
//   - a command reaches its actuator as soon as it is sent. What could come between - a crash, an
//     emergency stop, the end of the controller - commutes with the sending by somebody else, so
//     that the same happens where it comes before; a command that is to come later is held back.
//   - the end of a callback and its reply's arrival are one, as are a status and its arrival, a
//   crash
//     and its being heard of: what the controller hears of others meanwhile commutes with what
//     happened at the actuator. Where two messages of one actuator could overtake each other, one
//     is held back. A process that ends by itself is heard of later or, before its last reply, at
//     once.
//   - a status that says what the controller knows already changes nothing and is not waited for;
//   nor
//     is one that says that a command is running whose reply is waited for, once no fault is left:
//     whatever ends the wait brings a newer report.
//   - an emergency stop reaches all actuators at once, also between two commands of one wave; the
//     controller hears of it at any time. An actuator that hears of it later is another fault.
//   - before the first request nothing goes wrong but an emergency stop: the rest is another start.
// Actuators that have the same config are interchangeable: of nodes that differ by their names only
// one is searched (fingerprint.hpp).

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/lifecycle/actuator_core.hpp"
#include "musher/lifecycle/coordinator.hpp"

namespace musher::search {

inline constexpr std::size_t kActuators = 3;

// A command or a question, from the controller that sent it.
struct Message {
  std::size_t to = 0;
  Sender sender = 0;
  std::uint64_t epoch = 0;
  std::variant<SwitchCommand, AskCommand> what;
};

struct StopMessage {};

using Late = std::variant<Message, event::Replied, event::StatusSeen, StopMessage>;

enum class Work { kNone, kRunning, kOverdue };

struct Actor {
  bool alive = false;
  bool visible = false;
  Work work = Work::kNone;
  bool stop_requested = false;  // of the callback that runs
  bool energised = false;       // its output: on at the end of an upward callback
  bool status_due = false;
  std::int64_t reports = 0;
  std::int32_t processes = 0;  // its pid is this: nobody compares pids of different actuators
  ActuatorCore core;
  std::vector<event::Replied> replies;
  std::optional<bool> end;  // of its process, cleanly or not, on its way to the controller
  std::vector<Late> late;
  // By these the rules of commands are judged: the highest epoch and numbers that it has obeyed.
  std::uint64_t epoch = 0;
  std::uint64_t begun = 0;
  std::uint64_t asked = 0;
};

struct Request {
  State target;
  int answers = 0;
  bool gone = false;  // its controller has ended: whoever asked knows that
};

struct World {
  Time now{};
  int faults = 0;  // that may strike at all
  int faults_left = 0;
  Machine machine;
  std::array<Actor, kActuators> actors;
  std::vector<Message> outbox;
  std::vector<Request> requests;  // request n is the (n-1)th
  State from;                     // where the machine was before the first of them
  std::uint64_t generation = 0;   // of the controller
  std::uint64_t epoch_on_disk = 0;
  StoredStops stops_on_disk;
  bool at_start = false;       // nothing has been asked for yet
  bool stopped = false;        // an emergency stop has been engaged
  bool stop_seen_due = false;  // the controller has not heard of it
};

enum class Deed : std::uint8_t {
  // Nothing is wrong with these.
  kAsk,       // the first request
  kDeliver,   // the first of the outbox
  kEndOk,     // a callback ends, and its reply arrives
  kEndAsked,  // an overdue one ends because it was asked to stop
  kReply,     // the first of the replies
  kStatus,    // the latch
  kEnd,       // of a process
  kEndFirst,  // a torn down one's process ends, and that is heard before its reply
  kSeeStop,   // the controller does
  kTime,      // to the next deadline
  kLate,      // what was held back comes
  // Each of these is a fault.
  kLose,
  kHold,
  kDouble,
  kUnheard,  // the question of a controller that it has not heard of yet
  kEndFailed,
  kEndReplyLost,
  kEndReplyHeld,
  kEndReplyDoubled,
  kEndCrash,  // the callback ends, then its process, and that is heard before the reply
  kReplyLost,
  kReplyHeld,
  kReplyDoubled,
  kStatusLost,
  kStatusHeld,
  kStatusDoubled,
  kCrash,
  kRestart,  // the controller dies and another takes over
  kAskError,
  kAskTearDown,
  kEngageStop,
  kEngageStopLate,  // one actuator hears of it late: two faults
};

struct Choice {
  Deed deed = Deed::kAsk;
  std::uint8_t actuator = 0;
  std::uint8_t index = 0;  // of what is late
  std::uint8_t cost = 0;   // in faults
};

// The rules that are searched: the real ones, unless a test plants a fault in them.
struct Rules {
  std::function<std::vector<Action>(const MachineConfig&, Machine&, const Event&, Time)>
      controller = [](const auto& config, auto& machine, const auto& event, Time now) {
        return Step(config, machine, event, now);
      };
  std::function<std::vector<ActuatorAction>(const MachineConfig&, std::size_t, ActuatorCore&,
                                            const ActuatorEvent&, Time)>
      actuator = [](const auto& config, std::size_t i, auto& core, const auto& event, Time now) {
        return Step(config, i, core, event, now);
      };
};

struct Model {
  explicit Model(MachineConfig machine, State wanted = {}, Rules decisions = {});

  MachineConfig config;
  State target;  // of the first request
  Rules rules;
  std::array<std::size_t, kActuators> kinds{};  // equal for those that are interchangeable
};

// What was noticed while one choice was made.
struct Notes {
  bool tell = false;                  // whether `scenario` is wanted
  std::vector<std::string> scenario;  // in sentences
  std::vector<std::string> wrong;     // what is against the rules
};

// All that may happen next. Faults only as far as there are some left.
std::vector<Choice> Choices(const Model& model, const World& world);

// Makes a choice that Choices() gave.
void Make(const Model& model, World& world, const Choice& choice, Notes& notes);

// Whether nothing is left to happen but what a fault holds back.
bool IsQuiet(const World& world, const std::vector<Choice>& choices);

// A machine that is about to be started, and one that is started.
World NewWorld(const Model& model);
void Begin(const Model& model, World& world, bool by_hand, Notes& notes);
// Lets everything happen without a fault until the world is quiet.
void Settle(const Model& model, World& world, Notes& notes);
// Somebody asks for a switch.
void Ask(const Model& model, World& world, const State& target, Notes& notes);

}  // namespace musher::search
