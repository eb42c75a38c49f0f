// [robot]
#pragma once
// A robot that greets a person who comes, and keeps still when a person is too close.

#include <memory>
#include <string>
#include <vector>

#include "musher/behavior/fsm/machine.hpp"

namespace fsm = musher::fsm;

// The input and the output of the states. On a real robot subscriptions set the input, and the
// output is published.
struct Robot {
  bool sees_person = false;
  bool person_is_too_close = false;

  std::string pose;
  std::vector<std::string> said;
};
// [robot end]

// [idle]
class Idle : public fsm::State {
 public:
  explicit Idle(Robot& robot) : robot_(robot) {}

  void Declare(fsm::Transitions& transitions) override {
    greeting_ = transitions.To("GREETING", "a person comes");
    greet_ = transitions.On("greet");
  }
  void OnEnter(const fsm::Tick&) override { robot_.pose = "neutral"; }
  fsm::Next CheckTransition(const fsm::Tick& tick) override {
    const bool greets = robot_.sees_person || tick.command == greet_;
    return greets ? fsm::Next::To(greeting_) : fsm::Next::Stay();
  }

 private:
  Robot& robot_;
  fsm::StateId greeting_ = fsm::kNoState;
  fsm::EventId greet_ = fsm::kNoEvent;
};
// [idle end]

// [greeting]
class Greeting : public fsm::State {
 public:
  explicit Greeting(Robot& robot) : robot_(robot) {}

  void Declare(fsm::Transitions& transitions) override {
    idle_ = transitions.To("IDLE", "alone for 2 s");
  }
  void OnEnter(const fsm::Tick&) override {
    robot_.pose = "wave";
    robot_.said.emplace_back("Hello!");
    alone_for_ = {};
  }
  void Run(const fsm::Tick& tick) override {
    alone_for_ = robot_.sees_person ? musher::Duration{} : alone_for_ + tick.step;
  }
  fsm::Next CheckTransition(const fsm::Tick&) override {
    // The arm takes half a second to come down.
    return alone_for_ >= std::chrono::seconds(2)
               ? fsm::Next::To(idle_, std::chrono::milliseconds(500))
               : fsm::Next::Stay();
  }
  void Persist(fsm::Archive& archive) override { archive.Field("alone_for", alone_for_); }

 private:
  Robot& robot_;
  fsm::StateId idle_ = fsm::kNoState;
  musher::Duration alone_for_{};
};
// [greeting end]

// [safe]
class SafeStop : public fsm::State {
 public:
  explicit SafeStop(Robot& robot) : robot_(robot) {}

  void Declare(fsm::Transitions& transitions) override {
    idle_ = transitions.To("IDLE", "safe again");
  }
  void OnEnter(const fsm::Tick&) override { robot_.pose = "still"; }
  fsm::Next CheckTransition(const fsm::Tick& tick) override {
    return tick.elapsed >= std::chrono::seconds(1) ? fsm::Next::To(idle_) : fsm::Next::Stay();
  }

 private:
  Robot& robot_;
  fsm::StateId idle_ = fsm::kNoState;
};
// [safe end]

// [machine]
inline std::unique_ptr<fsm::Machine> MakeGreeter(Robot& robot) {
  auto machine = std::make_unique<fsm::Machine>(fsm::Machine::Options{.name = "greeter"});
  machine->AddEvent("greet");
  machine->Add("IDLE", std::make_unique<Idle>(robot));
  machine->Add("GREETING", std::make_unique<Greeting>(robot));
  machine->Add("SAFE_STOP", std::make_unique<SafeStop>(robot), fsm::Role::kSafe);
  machine->AddSafetyCheck("distance",
                          [&robot](const fsm::Tick&) { return !robot.person_is_too_close; });
  return machine;
}
// [machine end]
