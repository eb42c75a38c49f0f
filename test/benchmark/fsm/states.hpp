#pragma once
// States for a plain loop and for a machine, which do the same. They are made elsewhere, of two
// classes each, so that the compiler can inline no more than in an application.

#include <cstdint>
#include <memory>

#include "musher/behavior/fsm/state.hpp"

namespace musher::benchmark {

inline constexpr Duration kStay = Milliseconds(2000);  // in a state: a change in 100 ticks

// What the states work on.
struct Robot {
  std::uint64_t moves = 0;
  bool wants_out = false;
};

class PlainState {
 public:
  virtual ~PlainState() = default;
  virtual void OnEnter(Robot& robot) = 0;
  virtual int Check(const Robot& robot, Duration elapsed) = 0;  // the next one, or -1
  virtual void Run(Robot& robot) = 0;
  virtual void OnExit(Robot& robot) = 0;
};

// The one of this number, which goes to `next` once it has lasted longer than `stay`; in a machine
// it has that name.
std::unique_ptr<PlainState> MakePlainState(int number, int next, Duration stay);
std::unique_ptr<fsm::State> MakeState(Robot& robot, int number, int next, Duration stay);

}  // namespace musher::benchmark
