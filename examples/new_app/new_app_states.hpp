#pragma once
// The behaviour of NewApp, independent of topics, threads and clocks.

#include <chrono>
#include <memory>

#include "musher/behavior/fsm/machine.hpp"

// The input of the states, and their output.
struct NewAppData {
  bool obstacle = false;  // input: work must pause
  double progress = 0;    // output: 0 to 1
};

namespace fsm = musher::fsm;
using namespace std::chrono_literals;

class Idle : public fsm::State {
 public:
  void Declare(fsm::Transitions& transitions) override {
    working_ = transitions.To("WORKING", "go");
    go_ = transitions.On("go");
  }
  fsm::Next CheckTransition(const fsm::Tick& tick) override {
    return tick.command == go_ ? fsm::Next::To(working_) : fsm::Next::Stay();
  }

 private:
  fsm::StateId working_ = fsm::kNoState;
  fsm::EventId go_ = fsm::kNoEvent;
};

class Working : public fsm::State {
 public:
  explicit Working(NewAppData& data) : data_(data) {}
  void Declare(fsm::Transitions& transitions) override {
    idle_ = transitions.To("IDLE", "3 s later");
  }
  void OnEnter(const fsm::Tick&) override { data_.progress = 0; }
  void Run(const fsm::Tick& tick) override {
    data_.progress = std::chrono::duration<double>(tick.elapsed) / 3s;
  }
  fsm::Next CheckTransition(const fsm::Tick& tick) override {
    return tick.elapsed >= 3s ? fsm::Next::To(idle_) : fsm::Next::Stay();
  }

 private:
  NewAppData& data_;
  fsm::StateId idle_ = fsm::kNoState;
};

// An obstacle: the application waits, and starts again from IDLE once the path is free.
class Waiting : public fsm::State {
 public:
  void Declare(fsm::Transitions& transitions) override {
    idle_ = transitions.To("IDLE", "the path is free");
  }
  fsm::Next CheckTransition(const fsm::Tick&) override { return fsm::Next::To(idle_); }

 private:
  fsm::StateId idle_ = fsm::kNoState;
};

inline musher::Result<> BuildNewApp(fsm::Machine& machine, NewAppData& data) {
  machine.AddEvent("go");
  machine.Add("IDLE", std::make_unique<Idle>());
  machine.Add("WORKING", std::make_unique<Working>(data));
  machine.Add("WAITING", std::make_unique<Waiting>(), fsm::Role::kSafe);
  machine.AddSafetyCheck("an obstacle", [&data](const fsm::Tick&) { return !data.obstacle; });
  return machine.Build("IDLE");
}
