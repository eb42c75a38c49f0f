#pragma once
// <GetOffEdge message="{}"/>: a robot that something has stopped in the middle of a climb goes to
// the centre of a cell, on four short wheels. See edge.hpp for the way.
//
//   start ─→ the next step of the way ─→ done      SUCCESS: it is on level ground, wheels short
//              ↑        │
//              └────────┘  a drive, or a height of all wheels; asked again after each
//
// SUCCESS at once where there is nothing to do, or where no pose came and no climb was begun. It
// moves only where the way is certain; otherwise FAILURE with the reason. An error that was there
// before stays in last_error, with the outcome behind it. A halt cancels what runs.
//
// Threads: one at a time, like the tree.

#include <string>

#include "musher/behavior/tree/node.hpp"
#include "musher/behavior/tree/setup.hpp"
#include "musher/modules/meilin/nodes/edge.hpp"
#include "musher/modules/meilin/nodes/goal_watch.hpp"
#include "musher/modules/meilin/nodes/mission_board.hpp"

namespace musher::meilin {

class GetOffEdge final : public tree::StatefulAction {
 public:
  GetOffEdge(tree::Setup& setup, Robot& robot, const Settings& settings);

 private:
  static constexpr int kMostSteps = 10;

  tree::Status OnStart(const tree::Tick& tick) override;
  tree::Status OnRunning(const tree::Tick& tick) override;
  void OnHalted(const tree::Tick&) override { watch_.Cancel(); }

  tree::Status Next(Time now);
  void Begin(const OffEdgeStep& step, Time now);
  tree::Status Done(const Cell& cell, Time now);
  tree::Status Fail(const std::string& why);

  tree::OutPort<std::string> message_;
  Robot& robot_;
  const Settings& settings_;
  MissionBoard board_;
  GoalWatch watch_;
  int steps_ = 0;
  bool to_upper_ = false;  // the present drive
  bool upper_blocked_ = false;
  std::string before_;  // last_error at its start
};

}  // namespace musher::meilin
