#pragma once
// <Fetch kfs_row="" kfs_col="" height_diff="" target_yaw="" message="{}"/>: the robot goes near to
// a box on a cell beside its own, lifts its wheels to the height of that cell, and takes the box.
//
//   start ─→ reach ──────────────────────────→ grasp ─→ done
//            to the grasp pose, and the wheels   the arm
//            to normal height + height_diff
//
// It starts from the live pose where it is fresh, else from the cell that the mission remembers,
// with a warning: from where its plan was checked. The box must be on a neighbour. The wheels
// stay lifted: the offset is remembered, and the next Move lowers them first. A height below the
// ground is refused. Failures set last_error and ACTION_FAILED, and cancel what runs; so does a
// halt.
//
// Threads: one at a time, like the tree.

#include <optional>
#include <string>

#include "musher/behavior/tree/node.hpp"
#include "musher/behavior/tree/setup.hpp"
#include "musher/modules/meilin/nodes/goal_watch.hpp"
#include "musher/modules/meilin/nodes/place.hpp"

namespace musher::meilin {

class Fetch final : public tree::StatefulAction {
 public:
  Fetch(tree::Setup& setup, Robot& robot, const Settings& settings);

 private:
  tree::Status OnStart(const tree::Tick& tick) override;
  tree::Status OnRunning(const tree::Tick& tick) override { return Look(tick.now); }
  void OnHalted(const tree::Tick&) override { CancelAll(); }

  tree::Status Look(Time now);
  tree::Status LookAtReach(Time now);
  tree::Status Done();
  tree::Status Fail(const std::string& why);
  void CancelAll();

  tree::InPort<int> row_;
  tree::InPort<int> col_;
  tree::InPort<double> height_diff_mm_;
  tree::InPort<double> yaw_rad_;
  tree::OutPort<std::string> message_;
  Robot& robot_;
  const Settings& settings_;
  MissionBoard board_;
  Cell box_;
  double to_yaw_rad_ = 0;
  double lift_mm_ = 0;
  GoalWatch align_;
  GoalWatch suspension_;
  GoalWatch arm_;
};

}  // namespace musher::meilin
