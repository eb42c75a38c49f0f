#pragma once
// A state machine for applications: states are classes, registered at run time, so that a new state
// changes no other code. See state.hpp for states.
//
//   fsm::Machine machine({.name = "show"});
//   machine.AddEvent("photo");
//   machine.Add("IDLE", std::make_unique<Idle>(robot));
//   machine.Add("TRACKING", std::make_unique<Tracking>(robot));
//   machine.Add("SAFE_STOP", std::make_unique<SafeStop>(robot), fsm::Role::kSafe);
//   machine.AddSafetyCheck("too close", [&](const fsm::Tick&) { return !robot.too_close; });
//   if (const Result<> built = machine.Build("IDLE"); !built) ...  all its errors, a line each
//   machine.Start(now);
//   ... each 20 ms: machine.RunOnce(now);
//
// Modes: Normal; Transitioning during a gradual transition; SafeStop while it is in its safe state.
// The machine goes to its safe state in the same tick when a safety check fails or throws, or when
// a state throws, exceeds the longest transition, or goes to a state that it has not declared. It
// leaves the safe state only when the safe state decides so and every check passes again. A fault
// of the safe state itself stops the machine.
//
// A tick makes at most one transition, or one for each of `commands_per_tick` queued commands. It
// does not allocate, lock or read a clock.
//
// Threads: one at a time. A state or a listener may call Send(); the calls that change the machine
// fail inside of a tick.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/behavior/fsm/chart.hpp"
#include "musher/behavior/fsm/listener.hpp"
#include "musher/behavior/fsm/state.hpp"
#include "musher/behavior/recent.hpp"

namespace musher::fsm {

enum class Mode : std::uint8_t { kNormal, kTransitioning, kSafeStop };
std::string_view Name(Mode mode);  // NORMAL, TRANSITIONING, SAFE_STOP

enum class Urgency : std::uint8_t { kNormal, kUrgent };

using History = Recent<Change>;  // the last changes

// Counters of a machine since it was built.
struct Counts {
  std::uint64_t changes = 0;
  std::uint64_t unhandled = 0;   // commands not handled, also by an aborted transition
  std::uint64_t superseded = 0;  // commands dropped by an urgent one, a pause, a reset or a stop
  std::uint64_t refused = 0;     // commands refused by a full queue
  std::uint64_t faults = 0;
  std::uint64_t listener_faults = 0;

  friend bool operator==(const Counts&, const Counts&) = default;
};

struct Snapshot;  // snapshot.hpp
struct SnapshotFault;

class Machine {
 public:
  struct Options {
    std::string name = "machine";
    std::size_t history = 64;   // changes that are kept; 0: none
    std::size_t commands = 32;  // that may be queued
    // The commands that a tick handles at most, in order. For each after the first the state is
    // checked, and run if it stays, with a step of no time.
    std::size_t commands_per_tick = 1;
    Duration longest_transition = std::chrono::seconds(10);  // a longer one is a fault
  };

  Machine() : Machine(Options{}) {}
  explicit Machine(Options options);
  ~Machine();  // leaves no state: Stop() does
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;

  // --- before Build() ---

  StateId Add(std::string name, std::unique_ptr<State> state, Role role = Role::kNormal);
  // A command by its name. An urgent one is handled before all queued ones, and drops them.
  EventId AddEvent(std::string name, Urgency urgency = Urgency::kNormal) {
    return AddEvent(std::move(name), urgency, nullptr);
  }
  // The same with data; see event.hpp.
  template <class T>
  TypedEvent<T> AddEvent(std::string name, Urgency urgency = Urgency::kNormal) {
    return {AddEvent(std::move(name), urgency, EventTypeOf<T>())};
  }
  EventId AddEvent(std::string name, Urgency urgency, const EventType* type);
  // `is_safe` is called at the beginning and at the end of each tick; false leads to the safe
  // state.
  void AddSafetyCheck(std::string name, std::function<bool(const Tick&)> is_safe);

  // The shared data of the states, saved and restored with them. See archive.hpp.
  void AddData(std::string name, std::function<void(Archive&)> persist);

  // Calls Declare() of the states, and checks the chart (check.hpp). Fails with all errors, a line
  // each; then the machine cannot be started.
  Result<> Build(std::string_view start);
  // The warnings of Build(), a line each; see check.hpp.
  const std::vector<std::string>& warnings() const { return warnings_; }

  // --- run ---

  // Enters the start state. Also again after Stop(): with no commands and an empty history. Like
  // the other calls that change the state, it returns the fault when a state fails in it.
  Result<> Start(Time now) { return StartAt(chart_.start, now); }
  // The same, in another state.
  Result<> StartAt(StateId state, Time now);
  // Does nothing while the machine is not running. A time before the last one counts as no elapsed
  // time. Throws std::logic_error inside of a tick of the same machine: a fault of the state.
  void RunOnce(Time now);
  // The time until the next tick does not count. Queued commands are dropped, also those that wait
  // in a machine inside, but no urgent one: a command of hours ago is no longer wanted, a stop is.
  void Pause();
  // Leaves the state permanently.
  Result<> Stop();

  // The machine between two ticks, by names. Fails, naming the state, when one cannot persist
  // itself.
  Result<Snapshot> Save() const;
  // Continues from the snapshot, as if the last tick had been `now`. No state is entered. This
  // machine has to be built like the saved one, and must not run. Returns all errors of the
  // snapshot; if there are any, nothing has changed.
  [[nodiscard]] std::vector<SnapshotFault> Restore(const Snapshot& saved, Time now);

  // A command for the state to handle. Fails when it is not registered, when the queue is full, and
  // when the machine does not run.
  Result<> Send(EventId event) { return SendData(event, nullptr); }
  Result<> Send(std::string_view event);
  // The same with data. Fails also when the event carries other data.
  template <class T>
  Result<> Send(TypedEvent<T> event, T data) {
    return SendData(event.id, std::make_shared<EventDataOf<T>>(std::move(data)));
  }
  template <class T>
  Result<> Send(std::string_view event, T data) {
    const Result<EventId> found = EventOf(event);
    return found ? Send(TypedEvent<T>{found.value()}, std::move(data)) : found.error();
  }
  // For tools, which know the data of an event by its fields only: NewData() has their defaults,
  // and is null for an event without data.
  Result<> SendData(EventId event, std::shared_ptr<EventData> data);
  std::shared_ptr<EventData> NewData(EventId event) const;
  // At once, whether declared or not; queued commands stay.
  Result<> Force(StateId target);
  Result<> Force(std::string_view target);
  // Forces the start state and drops queued commands.
  Result<> Reset();

  // `listener` has to outlive the machine, or be removed with Forget(). A listener may call both.
  void Listen(Listener* listener);
  void Forget(Listener* listener);
  // The same for the inputs from outside, each of its ticks among them.
  void ListenToInputs(InputListener* listener);
  void ForgetInputs(InputListener* listener);

  // --- status ---

  bool running() const { return running_; }
  Mode mode() const { return mode_; }
  StateId current() const { return current_; }  // kNoState: not running
  std::uint64_t ticks() const { return ticks_; }
  Duration time() const { return tick_.now; }
  Duration elapsed() const { return tick_.elapsed; }
  const Counts& counts() const { return counts_; }
  const History& history() const { return history_; }
  // The last fault; if the machine is not running, this fault has stopped it.
  const std::optional<Fault>& fault() const { return fault_; }
  // The safety check that brought it to its safe state; empty: none.
  std::string_view unsafe() const;
  std::size_t waiting_commands() const { return waiting_; }

  const std::string& name() const { return options_.name; }
  // "" of kNoState. Of an id that Transitions::To() returned for a state of another machine: its
  // path from the outermost machine, with "/H" or "/H*" for the history.
  std::string_view Name(StateId state) const;
  std::string_view Name(EventId event) const;
  std::optional<StateId> FindState(std::string_view name) const;
  std::optional<EventId> FindEvent(std::string_view name) const;
  // Whether there is an event of that name, and it was registered as urgent.
  bool IsUrgent(std::string_view event) const;
  // "SHOW/PHOTO" where a state holds a machine, "SHOW/(WAVE|SMILE)" where it holds two.
  std::string Path() const;
  // The path of the state that holds this machine; "": no state holds it.
  std::string Place() const;
  // "SHOW/PHOTO: OnEnter: ..." of a fault.
  std::string Describe(const Fault& fault) const;
  std::size_t event_count() const { return events_.size(); }
  // As it was built.
  const Chart& chart() const { return chart_; }

 private:
  friend class Nested;

  struct Node {
    std::string name;
    std::unique_ptr<State> state;
    Role role;
    std::span<const std::unique_ptr<Machine>> inside;
    std::vector<EventId> handles{};
    std::vector<EventId> defers{};
  };
  // A state of this machine, or of one inside or around it.
  struct MachineState {
    Machine* machine;
    StateId state;
  };
  // A transition that ends in another machine, or inside of a state of this one. It leaves and
  // enters in `at`, the innermost machine that has both ends: the present state is left there, the
  // innermost one first; then `to` is entered, and `down`, the outermost one first.
  struct Route {
    StateId from;
    Machine* owner;  // of `from`
    Machine* at;
    StateId to;
    std::vector<MachineState> down;
    Into into;
    std::string target;  // its path from the outermost machine
    std::string name;    // the same, with "/H" or "/H*" for the history
  };
  // How a state is entered: by its start state, or along a route below this depth, or by history.
  struct Entry {
    const Route* route = nullptr;
    std::size_t depth = 0;
    Into into = Into::kStart;
  };
  struct Event {
    std::string name;
    Urgency urgency;
    const EventType* type;  // of its data; null: it has none
  };
  struct Command {
    EventId event = kNoEvent;
    std::shared_ptr<EventData> data;
  };
  struct SafetyCheck {
    std::string name;
    std::function<bool(const Tick&)> is_safe;
  };
  static constexpr std::size_t kNoCheck = static_cast<std::size_t>(-1);
  struct Data {
    std::string name;
    std::function<void(Archive&)> persist;
  };
  // Whether it is in a tick, or in another call that changes it.
  //
  // A plain tick needs to ask and run the state only: the machine runs, and has no safety checks,
  // no listeners of inputs, no commands and no transition under way. Each call that may change this
  // ends it, and the next tick finds out again.
  enum class TickKind : std::uint8_t {
    kNo,
    kNoPlainNext,  // no, and the next one will be plain
    kPlain,        // and so far it has stayed plain
    kAny,
  };
  class Declaration;
  class InTick;
  class Restorer;

  void DeclareStates();
  std::optional<Route> FindRoute(std::string_view target);
  std::optional<std::vector<MachineState>> FindBelow(std::string_view path);
  inline const Route* RouteOf(StateId target) const;
  std::optional<StateId> FindTarget(StateId from, std::string_view name) const;
  Result<> StartIn(StateId state, Time now, const Entry& entry);
  inline void GoTo(StateId target);
  [[gnu::noinline]] void Follow();
  [[gnu::noinline]] void StopInside();
  [[gnu::noinline]] void EnterInside(const Entry& entry);
  void SetEntries(const Entry& entry);
  [[gnu::noinline]] void CancelRequest();
  void CheckAll(std::string_view start);
  std::optional<std::size_t> FindCheck(std::string_view name) const;
  static std::string InsideName(const Node& node, const Machine& inside);
  Result<> SaveParts(Snapshot& saved) const;
  void Become(const Snapshot& saved, Time now);
  // What a state and the machines inside make of a command.
  enum class Use : std::uint8_t { kNothing, kDone, kKept };
  // What the present states have declared of it.
  enum class Word : std::uint8_t { kNothing, kHandles, kDefers };

  bool in_tick() const { return ticking_ >= TickKind::kPlain; }
  // The tick, and the next one, may have more to do than to ask and run the state.
  void EndPlain() { ticking_ = in_tick() ? TickKind::kAny : TickKind::kNo; }
  void Request(const Route& route) {
    requested_ = &route;
    EndPlain();
  }
  void RunAny(Time now);
  [[gnu::noinline]] void Finish(Next next);
  [[gnu::noinline]] void FinishAny(Next next);
  [[gnu::noinline]] void FinishRun();
  [[gnu::noinline]] void FinishFailed(Phase phase);
  inline void Advance(Time last, Time now);
  bool BeginTick(Time now);
  void EndTick();
  void RunStep();
  bool Step();
  bool Conclude(Next next);
  inline bool Execute(Next next);
  inline void Run();
  [[gnu::noinline]] void Keeps(EventId command, const Next& next);
  [[gnu::noinline]] void Drain();
  Use Decide(Time now, EventId command, const std::shared_ptr<EventData>& data);
  void RunDecided();
  Word WordOf(EventId command) const;
  std::size_t FirstWaiting() const;
  EventId InsideOf(EventId outer) const;
  inline void Begin(Next next);
  void Proceed();
  void SetPresent(StateId state);
  void SetAbsent();
  void Enter(StateId target, Cause cause, EventId command, const Entry& entry);
  void Switch(StateId target, Cause cause, EventId command, const Entry& entry);
  [[gnu::noinline]] bool PassesChecks();
  bool HandleUnsafe(const SafetyCheck& check, const std::optional<std::string>& thrown);
  void Note(Phase phase, std::string what, const std::string& inner = {});
  void Fail(Phase phase, std::string what);
  void LeaveFailed(Phase phase);
  [[gnu::noinline]] void FailByException(Phase phase);
  [[gnu::noinline]] void FailUndeclared(StateId target);
  [[gnu::noinline]] void FailEndless();
  inline void EndPresent(EventId command);
  void Halt(Cause cause);
  inline bool Declared(StateId from, StateId to) const;
  Result<> Reached(StateId target) const;
  Error Failure() const;
  void DropCommands() {
    counts_.superseded += waiting_;
    waiting_ = 0;
  }
  void DropNormalCommands();
  Result<EventId> EventOf(std::string_view name) const;
  Command& Queued(std::size_t i) { return commands_[(first_command_ + i) % commands_.size()]; }
  const Command& Queued(std::size_t i) const {
    return commands_[(first_command_ + i) % commands_.size()];
  }
  EventId TakeCommand();
  [[gnu::noinline]] void GiveBack(EventId command);
  [[gnu::noinline]] void Unhandled(EventId command);
  void NotifyInput(const Input& input);
  inline const Change& Remember(StateId to, EventId command, Cause cause);
  inline void NotifyChange(const Change& change);
  [[gnu::noinline]] void NotifyAround(const Change& change);
  template <class Call>
  bool Guard(Phase phase, Call&& call);
  template <class Interface, class Call>
  void NotifyAll(const std::vector<Interface*>& listeners, Call&& call);

  // The data that every tick reads, side by side; `tick_` first, so that its address is that of the
  // machine and takes no register of its own.
  Tick tick_;                 // the argument of the states; with the transition under way
  State* present_ = nullptr;  // the current state, ready to be called
  StateId current_ = kNoState;
  bool holds_machines_ = false;
  bool running_ = false;
  TickKind ticking_ = TickKind::kNo;
  Mode mode_ = Mode::kNormal;
  std::optional<Time> last_tick_;
  std::uint64_t ticks_ = 0;
  // A state inside goes along it, to be followed at the end of this step by the machine `at`.
  const Route* requested_ = nullptr;
  std::size_t waiting_ = 0;
  std::vector<Listener*> listeners_;  // null: removed during a notification
  std::vector<InputListener*> input_listeners_;
  std::vector<SafetyCheck> checks_;

  const Options options_;
  std::vector<Node> nodes_;
  std::vector<Event> events_;
  std::vector<Data> data_;
  std::vector<std::string> errors_;  // errors found so far
  std::vector<std::string> warnings_;
  Chart chart_;
  std::vector<Route> routes_;
  std::size_t first_route_ = 0;         // its id: they follow those of the states
  Machine* around_ = nullptr;           // null: this is the outermost machine
  StateId around_state_ = kNoState;     // the state of it that holds this machine
  Entry entry_;                         // for the next start, by the machine around this one
  std::vector<EventId> by_outer_;       // the events by those of the machine around, of this name
  bool defers_any_ = false;             // a state here or inside declares Defer()
  std::vector<std::uint8_t> declared_;  // of each pair of states: 1, its transition is declared
  StateId safe_ = kNoState;
  bool built_ = false;

  std::shared_ptr<EventData> event_data_;  // of the command of the tick
  EventId offered_ = kNoEvent;     // of the machine around, which gets it back if it is unused
  Use use_ = Use::kNothing;        // of this step
  bool stays_ = false;             // after Decide()
  EventId kept_ = kNoEvent;        // reported by OnKept() for the present state
  EventId cause_ = kNoEvent;       // the command behind the transition
  std::size_t unsafe_ = kNoCheck;  // the check that failed
  std::vector<Command> commands_;  // a ring
  std::size_t first_command_ = 0;
  History history_;
  std::optional<Fault> fault_;
  Counts counts_;
};

}  // namespace musher::fsm
