#pragma once
// A state machine for applications: states are classes, registered at run time, so that a new one
// touches nothing else. See state.hpp for what a state is.
//
//   fsm::Machine machine({.name = "show"});
//   machine.AddEvent("photo");
//   machine.Add("IDLE", std::make_unique<Idle>(robot));
//   machine.Add("TRACKING", std::make_unique<Tracking>(robot));
//   machine.Add("SAFE_STOP", std::make_unique<SafeStop>(robot), fsm::Role::kSafe);
//   machine.AddSafetyCheck("too close", [&](const fsm::Tick&) { return !robot.too_close; });
//   if (const Result<> built = machine.Build("IDLE"); !built) ...  every fault of it, a line each
//   machine.Start(now);
//   ... each 20 ms: machine.RunOnce(now);
//
// Modes: Normal; Transitioning while a gradual transition goes on; SafeStop while it is in its safe
// state. A safety check that fails or throws, or a state that throws, does not end a transition or
// goes where it did not declare to go, leads to the safe state in the same tick, and out of it only
// when the safe state decides so and every check is well again. A safe state that fails itself
// stops the machine.
//
// A tick makes at most one transition. It allocates nothing, locks nothing and reads no clock.
//
// Threads: one at a time. A state or a listener may call Send(); the calls that change the machine
// refuse to run inside of a tick.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/behavior/fsm/chart.hpp"
#include "musher/behavior/fsm/history.hpp"
#include "musher/behavior/fsm/listener.hpp"
#include "musher/behavior/fsm/state.hpp"
#include "musher/lifecycle/result.hpp"

namespace musher::fsm {

enum class Mode : std::uint8_t { kNormal, kTransitioning, kSafeStop };
std::string_view Name(Mode mode);  // NORMAL, TRANSITIONING, SAFE_STOP

enum class Urgency : std::uint8_t { kNormal, kUrgent };

// Of a machine's life, since it was built.
struct Counts {
  std::uint64_t changes = 0;
  std::uint64_t unhandled = 0;   // commands that came to nothing, also when a transition broke off
  std::uint64_t superseded = 0;  // commands that an urgent one, a reset or a stop swept away
  std::uint64_t refused = 0;     // commands that found no room
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
    std::size_t history = 64;                                // changes that are remembered; 0: none
    std::size_t commands = 32;                               // that may wait
    Duration longest_transition = std::chrono::seconds(10);  // a longer one is a fault
  };

  Machine() : Machine(Options{}) {}
  explicit Machine(Options options);
  ~Machine();  // leaves no state: Stop() does
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;

  // --- before Build() ---

  StateId Add(std::string name, std::unique_ptr<State> state, Role role = Role::kNormal);
  // A command by its name. An urgent one goes before all that wait, and sweeps them away.
  EventId AddEvent(std::string name, Urgency urgency = Urgency::kNormal);
  // `is_safe` is asked at the beginning and at the end of each tick; false leads to the safe state.
  void AddSafetyCheck(std::string name, std::function<bool(const Tick&)> is_safe);

  // What the states share, to be saved and restored with them. See archive.hpp.
  void AddData(std::string name, std::function<void(Archive&)> persist);

  // Asks the states what they declare, and judges the whole (check.hpp). Fails with every fault of
  // it, a line each; the machine cannot be started then.
  Result<> Build(std::string_view start);
  // What it found that may be meant, a line each; see check.hpp.
  const std::vector<std::string>& warnings() const { return warnings_; }

  // --- its life ---

  // Enters the start state. Also again, after Stop(): with no commands and an empty history. Like
  // the other calls that change the state it fails, with the fault, when a state failed by it.
  Result<> Start(Time now) { return StartAt(chart_.start, now); }
  // The same, in a state of your choice.
  Result<> StartAt(StateId state, Time now);
  // Does nothing while the machine is not running. A time before the last one counts as no time.
  void RunOnce(Time now);
  // The time until the next tick does not count.
  void Pause();
  // Leaves the state for good.
  Result<> Stop();

  // As it is between two ticks, by names. Fails, with the state, when one cannot persist itself.
  Result<Snapshot> Save() const;
  // Goes on from there, as if the last tick had been `now`. No state is entered. This machine is
  // built like the one that was saved, and does not run. Gives all that is wrong with the snapshot;
  // if anything is, nothing has changed.
  [[nodiscard]] std::vector<SnapshotFault> Restore(const Snapshot& saved, Time now);

  // A command for the state to handle. Fails when nobody registered it, when too many wait, and
  // when the machine does not run.
  Result<> Send(EventId event);
  Result<> Send(std::string_view event);
  // At once, whether declared or not; waiting commands stay.
  Result<> Force(StateId target);
  Result<> Force(std::string_view target);
  // Forces the start state and sweeps commands away.
  Result<> Reset();

  // `listener` outlives the machine, or is taken away. Both may be called by a listener.
  void Listen(Listener* listener);
  void Forget(Listener* listener);

  // --- what it is like ---

  bool running() const { return running_; }
  Mode mode() const { return mode_; }
  StateId current() const { return current_; }  // kNoState: not running
  std::uint64_t ticks() const { return ticks_; }
  Duration time() const { return tick_.now; }
  Duration elapsed() const { return tick_.elapsed; }
  const Counts& counts() const { return counts_; }
  const History& history() const { return history_; }
  // The last one; the machine has stopped by it if it is not running.
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
  class Declaring;
  class Restoring;

  void DeclareStates();
  void Judge(std::string_view start);
  std::optional<std::size_t> FindCheck(std::string_view name) const;
  Result<> SaveParts(Snapshot& saved) const;
  void Become(const Snapshot& saved, Time now);
  inline void Advance(Time now);
  inline void Step();
  void Follow(Next next);
  inline bool Run();
  void Begin(Next next);
  void Proceed();
  void Enter(StateId target, Cause cause, EventId command);
  void Switch(StateId target, Cause cause, EventId command);
  bool PassesChecks();
  bool GoesOnUnsafe(const SafetyCheck& check, const std::optional<std::string>& thrown);
  void Note(Phase phase, std::string what, const std::string& inner = {});
  void Fail(Phase phase, std::string what);
  void LeaveFailed(Phase phase);
  void FailByException(Phase phase);
  void EndPresent(EventId command);
  void Halt(Cause cause);
  bool Declared(StateId from, StateId to) const;
  Result<> Reached(StateId target) const;
  Error Failure() const;
  void SweepCommands() {
    counts_.superseded += waiting_;
    waiting_ = 0;
  }
  EventId TakeCommand();
  void GiveBack(EventId command);
  void Unhandled(EventId command);
  void TellInput(const Input& input);
  void Remember(const Change& change);
  template <class Call>
  bool Guard(Phase phase, Call&& call);
  template <class Call>
  void TellAll(Call&& call);

  const Options options_;
  std::vector<Node> nodes_;
  std::vector<Event> events_;
  std::vector<Data> data_;
  std::vector<std::string> wrong_;  // found so far
  std::vector<std::string> warnings_;
  Chart chart_;
  std::vector<std::uint64_t> declared_;  // a bit for each pair of states
  std::size_t row_ = 0;                  // words of one state in it
  StateId safe_ = kNoState;
  bool built_ = false;

  // What every tick looks at, side by side.
  bool running_ = false;
  bool in_tick_ = false;
  Mode mode_ = Mode::kNormal;
  StateId current_ = kNoState;
  State* present_ = nullptr;  // the same, ready to be called
  Tick tick_;                 // what states are told; of a transition, too, while one goes on
  std::optional<Time> last_tick_;
  std::uint64_t ticks_ = 0;
  std::size_t waiting_ = 0;
  std::vector<Listener*> listeners_;  // null: forgotten while they were being told
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
