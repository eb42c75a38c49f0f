// The machine against a minimal model: whatever the states do, both call the same functions in the
// same order, with the same times and commands.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <deque>
#include <map>
#include <stdexcept>

#include "musher/test/behavior/fsm/random_states.hpp"

namespace musher::fsm::model_test {

constexpr int kNone = -1;
constexpr int kStates = 4;
constexpr int kSafe = 3;
constexpr std::size_t kRoom = 3;
constexpr int kUrgent = 2;  // of the events 0, 1 and 2

// The action of the n-th call of a function of a state: the same in both.
struct StateAction {
  bool throws = false;
  int target = kNone;  // kStates: one that was not declared
  Duration gradually{};
  bool handles = false;
  bool keeps = false;
};

StateAction ActionOf(std::uint64_t seed, int state, Phase phase, int n) {
  const std::uint64_t bits = Mix(
      seed + Mix(static_cast<std::uint64_t>(state * 1000 + static_cast<int>(phase) * 100'000 + n)));
  StateAction action;
  action.throws = bits % 23 == 0;
  if ((bits >> 8) % 3 == 0) action.target = static_cast<int>((bits >> 16) % (kStates + 1));
  if (action.target == kStates && (bits >> 20) % 4 != 0) action.target = 0;
  if ((bits >> 24) % 2 == 0) action.gradually = Milliseconds((bits >> 32) % 80);
  action.handles = (bits >> 40) % 2 == 0;
  action.keeps = (bits >> 48) % 4 == 0;
  return action;
}

// A call, as both log it.
std::string Call(int state, Phase phase, const Tick& tick) {
  return std::to_string(state) + std::string(Name(phase)) + " " + std::to_string(tick.now.count()) +
         " " + std::to_string(tick.step.count()) + " " + std::to_string(tick.elapsed.count()) +
         " " + std::to_string(Index(tick.command)) + " " + std::to_string(Index(tick.target)) +
         " " + std::to_string(tick.transition_elapsed.count());
}

class ScriptedState : public State {
 public:
  ScriptedState(std::uint64_t seed, int state, std::vector<std::string>& log)
      : seed_(seed), state_(state), log_(log) {}
  void Declare(Transitions& transitions) override {
    for (int i = 0; i < kStates; ++i) transitions.To(std::to_string(i), "");
  }
  void OnEnter(const Tick& tick) override { Do(Phase::kEnter, tick); }
  void Run(const Tick& tick) override { Do(Phase::kRun, tick); }
  void OnExit(const Tick& tick) override { Do(Phase::kExit, tick); }
  bool Transition(const Tick& tick) override {
    Do(Phase::kTransition, tick);
    return State::Transition(tick);
  }
  Next CheckTransition(const Tick& tick) override {
    const StateAction action = Do(Phase::kCheck, tick);
    Next next = action.target == kNone
                    ? (action.handles ? Next::Handle() : Next::Stay())
                    : Next::To(static_cast<StateId>(action.target), action.gradually);
    return action.keeps ? next.KeepCommand() : next;
  }

 private:
  StateAction Do(Phase phase, const Tick& tick) {
    log_.push_back(Call(state_, phase, tick));
    const StateAction action = ActionOf(seed_, state_, phase, calls_[phase]++);
    if (action.throws) throw std::runtime_error("action");
    return action;
  }

  const std::uint64_t seed_;
  const int state_;
  std::vector<std::string>& log_;
  std::map<Phase, int> calls_;
};

class Model {
 public:
  explicit Model(std::uint64_t seed) : seed_(seed) {}

  void Start() {
    if (current_ != kNone) return;
    time_ = step_ = {};
    commands_.clear();
    Enter(0);
  }
  void Tick(Duration passed, bool safe) {
    if (current_ == kNone) return;
    step_ = passed;
    time_ += passed;
    if (!safe && current_ != kNone && (current_ != kSafe || target_ != kNone)) return Leave(kSafe);
    if (target_ != kNone) {
      Proceed();
    } else {
      Check(safe);
    }
    if (!safe && current_ != kNone && (current_ != kSafe || target_ != kNone)) Leave(kSafe);
  }
  void Send(int command) {
    if (current_ == kNone) return;
    if (command == kUrgent) commands_.clear();
    if (commands_.size() < kRoom) commands_.push_back(command);
  }
  void Force(int state) {
    if (current_ != kNone) Leave(state);
  }
  void Reset() {
    if (current_ == kNone) return;
    commands_.clear();
    Leave(0);
  }
  void Stop() {
    if (current_ == kNone) return;
    Calls(Phase::kExit);
    current_ = target_ = kNone;
  }

  std::vector<std::string> log;
  int current() const { return current_; }

 private:
  fsm::Tick Now(int command = kNone) const {
    fsm::Tick tick{.now = time_, .step = step_, .elapsed = time_ - entered_};
    if (command != kNone) tick.command = static_cast<EventId>(command);
    if (target_ != kNone) {
      tick.target = static_cast<StateId>(target_);
      tick.transition_elapsed = time_ - began_;
    }
    return tick;
  }
  bool Calls(Phase phase, StateAction* action = nullptr, int command = kNone) {
    log.push_back(Call(current_, phase, Now(command)));
    const StateAction done = ActionOf(seed_, current_, phase, calls_[{current_, phase}]++);
    if (action != nullptr) *action = done;
    return !done.throws;
  }
  void Check(bool safe) {
    int command = kNone;
    if (!commands_.empty()) {
      command = commands_.front();
      commands_.pop_front();
    }
    StateAction action;
    if (!Calls(Phase::kCheck, &action, command)) return Fails(true);
    if (action.keeps && command != kNone) {
      commands_.push_front(command);
      command = kNone;
    }
    if (action.target == kNone || (current_ == kSafe && !safe)) {
      if (!Calls(Phase::kRun, nullptr, command)) Fails(true);
      return;
    }
    if (action.target == kStates) return Fails(true);
    target_ = action.target;
    began_ = time_;
    duration_ = action.gradually;
    Proceed();
  }
  void Proceed() {
    if (!Calls(Phase::kTransition)) return Fails(true);
    if (time_ - began_ >= duration_) Leave(target_);
  }
  void Leave(int state) {
    if (Calls(Phase::kExit)) {
      Enter(state);
    } else {
      Fails(false);
    }
  }
  void Enter(int state) {
    current_ = state;
    target_ = kNone;
    entered_ = time_;
    if (!Calls(Phase::kEnter)) Fails(false);
  }
  void Fails(bool is_left) {
    if (current_ == kSafe) {
      current_ = target_ = kNone;
      return;
    }
    if (is_left) Calls(Phase::kExit);
    Enter(kSafe);
  }

  const std::uint64_t seed_;
  int current_ = kNone;
  int target_ = kNone;
  Duration time_{}, step_{}, entered_{}, began_{}, duration_{};
  std::deque<int> commands_;
  std::map<std::pair<int, Phase>, int> calls_;
};

RC_GTEST_PROP(Machine, DoesWhatItsModelDoes, (std::uint64_t seed)) {
  std::vector<std::string> log;
  Machine machine({.name = "actions", .history = 8, .commands = kRoom});
  for (int i = 0; i < kStates; ++i) {
    machine.Add(std::to_string(i), std::make_unique<ScriptedState>(seed, i, log),
                i == kSafe ? Role::kSafe : Role::kNormal);
  }
  for (const char* event : {"a", "b"}) machine.AddEvent(event);
  machine.AddEvent("stop", Urgency::kUrgent);
  bool safe = true;
  machine.AddSafetyCheck("safe", [&](const Tick&) { return safe; });
  RC_ASSERT(machine.Build("0").ok());

  Model model(seed);
  Time now{};
  model.Start();
  (void)machine.Start(now).ok();
  for (const RandomInput& step : AnyInputs()) {
    const int value = static_cast<int>(step.value);
    switch (step.kind) {
      case 0:
        model.Tick(Milliseconds(value), safe);
        machine.RunOnce(now += Milliseconds(value));
        break;
      case 1:
        model.Send(value % 3);
        (void)machine.Send(static_cast<EventId>(value % 3)).ok();
        break;
      case 2:
        safe = value % 4 != 0;
        break;
      case 3:
        model.Force(value % kStates);
        (void)machine.Force(static_cast<StateId>(value % kStates)).ok();
        break;
      case 4:
        model.Reset();
        (void)machine.Reset().ok();
        break;
      case 6:
        model.Stop();
        (void)machine.Stop().ok();
        break;
      default:
        model.Start();
        (void)machine.Start(now).ok();
    }
    RC_ASSERT(log == model.log);
    RC_ASSERT(machine.running() == (model.current() != kNone));
  }
}

}  // namespace musher::fsm::model_test
