#pragma once
// A scripted state for tests that logs its calls.

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/behavior/fsm/state.hpp"

namespace musher::fsm {

using Log = std::vector<std::string>;

class LoggingState : public State {
 public:
  LoggingState(std::string name, Log& log, std::vector<std::string> transitions = {})
      : name_(std::move(name)), log_(log), transitions_(std::move(transitions)) {}

  void Declare(Transitions& transitions) override {
    for (const std::string& way : transitions_) ids_[way] = transitions.To(way, "commanded");
    if (declare) declare(transitions);
  }
  void OnEnter(const Tick& tick) override { Do("enter", tick); }
  void Run(const Tick& tick) override { Do("run", tick); }
  Next CheckTransition(const Tick& tick) override {
    const Next next = std::exchange(next_, Next::Stay());
    return next.stays() && check ? check(tick) : next;
  }
  bool Transition(const Tick& tick) override {
    if (!State::Transition(tick)) {
      Do("transition", tick);
      return false;
    }
    return true;
  }
  void OnExit(const Tick& tick) override { Do("exit", tick); }

  // Goes there in the next tick.
  void Go(const std::string& target, Duration gradually = {}) {
    next_ = Next::To(ids_.at(target), gradually);
  }

  std::function<void(Transitions&)> declare;
  std::function<Next(const Tick&)> check;
  std::map<std::string, std::function<void(const Tick&)>, std::less<>> on;  // "enter", "run", ...

 private:
  void Do(std::string_view what, const Tick& tick) {
    log_.push_back(name_ + " " + std::string(what));
    if (const auto found = on.find(what); found != on.end()) found->second(tick);
  }

  const std::string name_;
  Log& log_;
  Next next_ = Next::Stay();
  const std::vector<std::string> transitions_;
  std::map<std::string, StateId> ids_;
};

}  // namespace musher::fsm
