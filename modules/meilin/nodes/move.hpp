#pragma once
// <Move move_row="" move_col="" target_height_mm="" target_yaw="" message="{}"/>: the robot goes to
// the centre of a cell, and climbs where that cell has another height.
//
//   start ─→ settle ──────────────────────────→ travel ─────────────────→ done
//            back to the centre of its cell      to the centre of the target cell,
//            wheels to their normal height       and the climb at the same time
//
// `settle` is left out where there is nothing to do. A climb begins only at the centre of a cell,
// with the heading of the target, within the tolerance: the robot returns to the centre before. It
// also lowers the wheels that a fetch has left lifted, but not for a climb up, which lifts them
// anyway. Then the climb
// and the path to the target run together on purpose: the wheels change when the body is at the
// edge. The direction of the climb is that of the path in the frame of the body.
//
// The start is the live pose where it is fresh, else what the mission remembers, with a warning. It
// does not begin on an edge (GetOffEdge does), climb from another cell than its plan was checked
// from, or go straight over cells of another height. It has not succeeded while wheels are out.
// Failures set last_error and ACTION_FAILED, and cancel what runs; so does a halt. A halt during a
// climb leaves the robot between two platforms: last_error says so.
//
// Threads: one at a time, like the tree.

#include <optional>
#include <string>

#include "musher/behavior/tree/node.hpp"
#include "musher/behavior/tree/setup.hpp"
#include "musher/modules/meilin/nodes/goal_watch.hpp"
#include "musher/modules/meilin/nodes/place.hpp"

namespace musher::meilin {

class Move final : public tree::StatefulAction {
 public:
  Move(tree::Setup& setup, Robot& robot, const Settings& settings);

 private:
  struct Plan {
    RobotPlace from;
    Cell to;
    double to_height_mm = 0;
    double to_yaw_rad = 0;
    std::optional<MoveGoal> pre_align;
    bool lowers = false;
    std::optional<SuspensionGoal> climb;
  };

  tree::Status OnStart(const tree::Tick& tick) override;
  tree::Status OnRunning(const tree::Tick& tick) override;
  void OnHalted(const tree::Tick& tick) override;

  // Empty: `plan_` is made. Else the failure.
  std::string MakePlan(Time now);
  // Empty: the straight way is flat.
  std::string CheckFlat(Time now) const;
  std::string PlanClimb();
  void Prepare(Time now);
  void Travel(Time now);
  bool preparing() const { return preparing_; }
  tree::Status Look(Time now);
  tree::Status Done(Time now);
  tree::Status Fail(const std::string& why);

  tree::InPort<int> row_;
  tree::InPort<int> col_;
  tree::InPort<double> height_mm_;
  tree::InPort<double> yaw_rad_;
  tree::OutPort<std::string> message_;
  Robot& robot_;
  const Settings& settings_;
  MissionBoard board_;
  Plan plan_;
  bool preparing_ = false;
  GoalWatch align_;
  GoalWatch suspension_;
};

}  // namespace musher::meilin
