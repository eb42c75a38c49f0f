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
// A tick makes at most one transition. It does not allocate, lock or read a clock.
//
// Threads: one at a time. A state or a listener may call Send(); the calls that change the machine
// fail inside of a tick.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
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
  std::uint64_t superseded = 0;  // commands dropped by an urgent one, a reset or a stop
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
    std::size_t history = 64;                                // changes that are kept; 0: none
    std::size_t commands = 32;                               // that may be queued
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
  EventId AddEvent(std::string name, Urgency urgency = Urgency::kNormal);
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
  // time.
  void RunOnce(Time now);
  // The time until the next tick does not count.
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
  Result<> Send(EventId event);
  Result<> Send(std::string_view event);
  // At once, whether declared or not; queued commands stay.
  Result<> Force(StateId target);
  Result<> Force(std::string_view target);
  // Forces the start state and drops queued commands.
  Result<> Reset();

  // `listener` has to outlive the machine, or be removed with Forget(). A listener may call both.
  void Listen(Listener* listener);
  void Forget(Listener* listener);

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
  std::string_view Name(StateId state) const;  // "" of kNoState
  std::string_view Name(EventId event) const;
  std::optional<StateId> FindState(std::string_view name) const;
  std::optional<EventId> FindEvent(std::string_view name) const;
  // "SHOW/PHOTO" where a state holds a machine.
  std::string Path() const;
  // "SHOW/PHOTO: OnEnter: ..." of a fault.
  std::string Describe(const Fault& fault) const;
  std::size_t event_count() const { return events_.size(); }
  // As it was built.
  const Chart& chart() const { return chart_; }

 private:
  struct Node {
    std::string name;
    std::unique_ptr<State> state;
    Role role;
  };
  struct Event {
    std::string name;
    Urgency urgency;
  };
  struct SafetyCheck {
    std::string name;
    std::function<bool(const Tick&)> is_safe;
  };
  struct Data {
    std::string name;
    std::function<void(Archive&)> persist;
  };
  class Declaration;
  class Restorer;

  void DeclareStates();
  void CheckAll(std::string_view start);
  std::optional<std::size_t> FindCheck(std::string_view name) const;
  Result<> SaveParts(Snapshot& saved) const;
  void Become(const Snapshot& saved, Time now);
  inline void Advance(Time now);
  inline void Step();
  void Execute(Next next);
  inline bool Run();
  void Begin(Next next);
  void Proceed();
  void Enter(StateId target, Cause cause, EventId command);
  void Switch(StateId target, Cause cause, EventId command);
  bool PassesChecks();
  bool HandleUnsafe(const SafetyCheck& check, const std::optional<std::string>& thrown);
  void Note(Phase phase, std::string what, const std::string& inner = {});
  void Fail(Phase phase, std::string what);
  void LeaveFailed(Phase phase);
  void FailByException(Phase phase);
  void EndPresent(EventId command);
  void Halt(Cause cause);
  bool Declared(StateId from, StateId to) const;
  Result<> Reached(StateId target) const;
  Error Failure() const;
  void DropCommands() {
    counts_.superseded += waiting_;
    waiting_ = 0;
  }
  EventId TakeCommand();
  void GiveBack(EventId command);
  void Unhandled(EventId command);
  void NotifyInput(const Input& input);
  void Remember(const Change& change);
  template <class Call>
  bool Guard(Phase phase, Call&& call);
  template <class Call>
  void NotifyAll(Call&& call);

  const Options options_;
  std::vector<Node> nodes_;
  std::vector<Event> events_;
  std::vector<Data> data_;
  std::vector<std::string> errors_;  // errors found so far
  std::vector<std::string> warnings_;
  Chart chart_;
  std::vector<std::uint64_t> declared_;  // a bit for each pair of states
  std::size_t row_ = 0;                  // words of one state in it
  StateId safe_ = kNoState;
  bool built_ = false;

  // The data that every tick reads, side by side.
  bool running_ = false;
  bool in_tick_ = false;
  Mode mode_ = Mode::kNormal;
  StateId current_ = kNoState;
  State* present_ = nullptr;  // the same, ready to be called
  Tick tick_;                 // the argument of the states; with the transition under way
  std::optional<Time> last_tick_;
  std::uint64_t ticks_ = 0;
  std::size_t waiting_ = 0;
  std::vector<Listener*> listeners_;  // null: removed during a notification
  std::vector<SafetyCheck> checks_;

  EventId cause_ = kNoEvent;       // the command behind the transition
  std::size_t unsafe_;             // index of the check, or their number
  std::vector<EventId> commands_;  // a ring
  std::size_t first_command_ = 0;
  History history_;
  std::optional<Fault> fault_;
  Counts counts_;
};

}  // namespace musher::fsm
