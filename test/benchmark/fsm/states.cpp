#include "musher/test/benchmark/fsm/states.hpp"

#include <string>

namespace musher::benchmark {
namespace {

class PlainWalk : public PlainState {
 public:
  PlainWalk(int next, Duration stay) : next_(next), stay_(stay) {}
  void OnEnter(Robot& robot) override { robot.wants_out = false; }
  int Check(const Robot& robot, Duration elapsed) override {
    return robot.wants_out || elapsed > stay_ ? next_ : -1;
  }
  void Run(Robot& robot) override { ++robot.moves; }
  void OnExit(Robot& robot) override { ++robot.moves; }

 private:
  const int next_;
  const Duration stay_;
};

class PlainJump : public PlainWalk {
 public:
  using PlainWalk::PlainWalk;
  void Run(Robot& robot) override { robot.moves += 2; }
};

class Walk : public fsm::State {
 public:
  Walk(Robot& robot, int next, Duration stay)
      : robot_(robot), next_name_(std::to_string(next)), stay_(stay) {}
  void Declare(fsm::Transitions& transitions) override {
    next_ = transitions.To(next_name_, "it is time");
  }
  void OnEnter(const fsm::Tick&) override { robot_.wants_out = false; }
  fsm::Next CheckTransition(const fsm::Tick& tick) override {
    return robot_.wants_out || tick.elapsed > stay_ ? fsm::Next::To(next_) : fsm::Next::Stay();
  }
  void Run(const fsm::Tick&) override { ++robot_.moves; }
  void OnExit(const fsm::Tick&) override { ++robot_.moves; }

 protected:
  Robot& robot_;

 private:
  const std::string next_name_;
  const Duration stay_;
  fsm::StateId next_ = fsm::kNoState;
};

class Jump : public Walk {
 public:
  using Walk::Walk;
  void Run(const fsm::Tick&) override { robot_.moves += 2; }
};

}  // namespace

std::unique_ptr<PlainState> MakePlainState(int number, int next, Duration stay) {
  if (number % 2 == 0) return std::make_unique<PlainWalk>(next, stay);
  return std::make_unique<PlainJump>(next, stay);
}

std::unique_ptr<fsm::State> MakeState(Robot& robot, int number, int next, Duration stay) {
  if (number % 2 == 0) return std::make_unique<Walk>(robot, next, stay);
  return std::make_unique<Jump>(robot, next, stay);
}

}  // namespace musher::benchmark
