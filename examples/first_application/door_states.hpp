// [data]
#pragma once
// The behaviour of an automatic door, independent of topics, threads and clocks.

#include "musher/behavior/fsm/machine.hpp"

// The input of the states, and their output.
struct DoorData {
  bool obstacle = false;  // something is in the way
  double opening = 0;     // 0 shut, 1 open
};
// [data end]

// [states]
namespace fsm = musher::fsm;
using namespace std::chrono_literals;

class Closed : public fsm::State {
 public:
  explicit Closed(DoorData& door) : door_(door) {}
  void Declare(fsm::Transitions& transitions) override {
    open_ = transitions.To("OPEN", "open");
    open_command_ = transitions.On("open");
  }
  void OnEnter(const fsm::Tick&) override { door_.opening = 0; }
  fsm::Next CheckTransition(const fsm::Tick& tick) override {
    return tick.command == open_command_ ? fsm::Next::To(open_, 2s) : fsm::Next::Stay();
  }
  // Opening takes two seconds.
  bool Transition(const fsm::Tick& tick) override {
    door_.opening = tick.progress();
    return State::Transition(tick);
  }

 private:
  DoorData& door_;
  fsm::StateId open_ = fsm::kNoState;
  fsm::EventId open_command_ = fsm::kNoEvent;
};

class Open : public fsm::State {
 public:
  explicit Open(DoorData& door) : door_(door) {}
  void Declare(fsm::Transitions& transitions) override {
    closed_ = transitions.To("CLOSED", "5 s later");
  }
  void OnEnter(const fsm::Tick&) override { door_.opening = 1; }
  fsm::Next CheckTransition(const fsm::Tick& tick) override {
    return tick.elapsed >= 5s ? fsm::Next::To(closed_, 2s) : fsm::Next::Stay();
  }
  bool Transition(const fsm::Tick& tick) override {
    door_.opening = 1 - tick.progress();
    return State::Transition(tick);
  }

 private:
  DoorData& door_;
  fsm::StateId closed_ = fsm::kNoState;
};

// An obstacle: the door stays where it is, and opens once the path is free.
class Blocked : public fsm::State {
 public:
  explicit Blocked(DoorData& door) : door_(door) {}
  void Declare(fsm::Transitions& transitions) override {
    open_ = transitions.To("OPEN", "the way is free");
  }
  void OnEnter(const fsm::Tick&) override { from_ = door_.opening; }
  fsm::Next CheckTransition(const fsm::Tick&) override { return fsm::Next::To(open_, 2s); }
  bool Transition(const fsm::Tick& tick) override {
    door_.opening = from_ + (1 - from_) * tick.progress();
    return State::Transition(tick);
  }

 private:
  DoorData& door_;
  double from_ = 0;
  fsm::StateId open_ = fsm::kNoState;
};
// [states end]

// [build]
inline musher::Result<> BuildDoor(fsm::Machine& machine, DoorData& door) {
  machine.AddEvent("open");
  machine.Add("CLOSED", std::make_unique<Closed>(door));
  machine.Add("OPEN", std::make_unique<Open>(door));
  machine.Add("BLOCKED", std::make_unique<Blocked>(door), fsm::Role::kSafe);
  machine.AddSafetyCheck("an obstacle", [&door](const fsm::Tick&) { return !door.obstacle; });
  return machine.Build("CLOSED");
}
// [build end]
