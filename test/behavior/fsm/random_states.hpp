#pragma once
// Machines whose states act pseudo-randomly, from a seed and their inputs: for property tests. They
// stay, leave at once or gradually, handle, keep or ignore commands, send some, and throw.

#include <rapidcheck.h>

#include <array>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "musher/behavior/fsm/nested.hpp"

namespace musher::fsm {

// The input data of the states of an application.
struct Facts {
  std::int64_t number = 0;
};

inline std::uint64_t Mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

inline constexpr std::array<const char*, 5> kRandomStates{"A", "B", "C", "D", "SAFE"};
inline constexpr std::array<const char*, 3> kRandomEvents{"go", "look around", "stop"};

class RandomState : public State {
 public:
  RandomState(std::uint64_t seed, Facts& facts, Machine& machine)
      : seed_(seed), facts_(facts), machine_(machine) {}

  void Declare(Transitions& transitions) override {
    for (const char* state : kRandomStates)
      transitions_.push_back(transitions.To(state, "at random"));
    transitions_.push_back(StateId{77});  // unknown
  }
  void OnEnter(const Tick& tick) override { Maybe(tick, 1); }
  void Run(const Tick& tick) override { Maybe(tick, 2); }
  bool Transition(const Tick& tick) override {
    Maybe(tick, 3);
    return State::Transition(tick);
  }
  void OnExit(const Tick& tick) override { Maybe(tick, 4); }
  Next CheckTransition(const Tick& tick) override {
    const std::uint64_t bits = Maybe(tick, 5);
    if (bits % 8 < 5) return bits % 8 < 2 ? Next::Handle() : Next::Stay();
    const StateId to = transitions_[(bits >> 8) % (bits % 1024 == 7 ? 6 : 5)];
    const Next next = Next::To(to, Milliseconds((bits >> 16) % 3 == 0 ? (bits >> 24) % 90 : 0));
    return (bits >> 32) % 4 == 0 ? next.KeepCommand() : next;
  }
  void Persist(Archive& archive) override {
    archive.Field("calls", calls_);
    archive.Field("seen", seen_);
    archive.Field("a share", share_);
    archive.Field("text", text_);
    archive.Field("odd", odd_);
  }

 private:
  std::uint64_t Maybe(const Tick& tick, std::uint64_t phase) {
    ++calls_;
    const std::uint64_t bits =
        Mix(seed_ + Mix(static_cast<std::uint64_t>(calls_ * 8) + phase +
                        Mix(static_cast<std::uint64_t>(tick.elapsed.count()) * 3 +
                            static_cast<std::uint64_t>(facts_.number) + Index(tick.command))));
    seen_ += tick.step;
    share_ += tick.progress() / 3;
    odd_ = !odd_;
    text_ = std::to_string(bits % 1000) + "\"\n\\ü";
    if (bits % 41 == 0) (void)machine_.Send(kRandomEvents[bits % 3]).ok();
    if (bits % 61 == 0) throw std::runtime_error("random " + std::to_string(bits % 10));
    return bits >> 3;
  }

  const std::uint64_t seed_;
  const Facts& facts_;
  Machine& machine_;
  std::vector<StateId> transitions_;
  std::int64_t calls_ = 0;
  Duration seen_{};
  double share_ = 0.1;
  std::string text_;
  bool odd_ = false;
};

// Of five states; D holds a machine of the same kind, `depth` times.
inline std::unique_ptr<Machine> RandomMachine(std::uint64_t seed, Facts& facts, int depth = 1,
                                              std::size_t history = 500) {
  auto machine = std::make_unique<Machine>(Machine::Options{
      .name = "random " + std::to_string(depth), .history = history, .commands = 4});
  for (const char* event : kRandomEvents) {
    machine->AddEvent(event,
                      std::string_view(event) == "stop" ? Urgency::kUrgent : Urgency::kNormal);
  }
  for (std::size_t i = 0; i < kRandomStates.size(); ++i) {
    const std::uint64_t own = Mix(seed * 10 + i);
    const Role role = i == 4 ? Role::kSafe : Role::kNormal;
    if (i == 3 && depth > 0) {
      class Outer : public Nested {
       public:
        using Nested::Nested;
        void Declare(Transitions& transitions) override {
          Nested::Declare(transitions);
          back_ = transitions.To("A", "later");
        }
        Next Decide(const Tick& tick) override {
          return tick.elapsed > Milliseconds(400) ? Next::To(back_) : Next::Stay();
        }

       private:
        StateId back_ = kNoState;
      };
      machine->Add(kRandomStates[i],
                   std::make_unique<Outer>(RandomMachine(own, facts, depth - 1, history), "A",
                                           Nested::Options{.resumes = seed % 2 == 0}));
    } else {
      machine->Add(kRandomStates[i], std::make_unique<RandomState>(own, facts, *machine), role);
    }
  }
  machine->AddSafetyCheck("number", [&facts](const Tick&) {
    if (facts.number == 13) throw std::runtime_error("thirteen");
    return facts.number % 11 != 5;
  });
  machine->AddData("facts", [&facts](Archive& archive) { archive.Field("number", facts.number); });
  return machine;
}

// An input of a machine.
struct RandomInput {
  int kind = 0;  // see ApplyTo()
  std::int64_t value = 0;
};

inline std::vector<RandomInput> AnyInputs() {
  return *rc::gen::container<std::vector<RandomInput>>(rc::gen::apply(
      [](int kind, std::int64_t value) {
        return RandomInput{kind, value};
      },
      rc::gen::weightedElement<int>(
          {{30, 0}, {6, 1}, {4, 2}, {1, 3}, {1, 4}, {1, 5}, {1, 6}, {1, 7}}),
      rc::gen::inRange<std::int64_t>(0, 60)));
}

// `now` is the clock; it may go back. `input` is called for a change of the facts.
template <class OnInput>
void ApplyTo(Machine& machine, const RandomInput& step, Time& now, Facts& facts,
             const OnInput& input) {
  const auto index = static_cast<std::size_t>(step.value);
  switch (step.kind) {
    case 0:
      now += Milliseconds(step.value == 59 ? 3'600'000 : step.value - 5);
      machine.RunOnce(now);
      break;
    case 1:
      (void)machine.Send(kRandomEvents[index % kRandomEvents.size()]).ok();
      break;
    case 2:
      facts.number = step.value;
      input(facts.number);
      break;
    case 3:
      (void)machine.Force(kRandomStates[index % kRandomStates.size()]).ok();
      break;
    case 4:
      (void)machine.Reset().ok();
      break;
    case 5:
      machine.Pause();
      break;
    case 6:
      (void)machine.Stop().ok();
      break;
    default:
      (void)machine.Start(now).ok();
  }
}

}  // namespace musher::fsm
