#include "musher/modules/meilin/nodes/get_off_edge.hpp"

#include "musher/modules/meilin/nodes/place.hpp"

namespace musher::meilin {

using tree::Status;

GetOffEdge::GetOffEdge(tree::Setup& setup, Robot& robot, const Settings& settings)
    : message_(setup.Output<std::string>("message", "where the robot has come to, or the failure")),
      robot_(robot),
      settings_(settings),
      board_(setup.board()) {}

Status GetOffEdge::OnStart(const tree::Tick& tick) {
  steps_ = 0;
  upper_blocked_ = false;
  before_ = board_.last_error.Get();
  return Next(tick.now);
}

Status GetOffEdge::OnRunning(const tree::Tick& tick) {
  const Status status = watch_.Look(tick.now);
  if (status == Status::kRunning) return status;
  if (status == Status::kFailure) {
    if (!to_upper_ || upper_blocked_) return Fail(watch_.failure());
    upper_blocked_ = true;  // a box, for example: back then
    robot_.Warn("the way off the edge is blocked: " + watch_.failure());
  }
  watch_.Release();
  return Next(tick.now);
}

Status GetOffEdge::Next(Time now) {
  const std::optional<PoseFix> pose = FreshPose(robot_, settings_, now);
  if (!pose) {
    if (!board_.climbing.Get() && steps_ == 0) return Status::kSuccess;
    return Fail("no fresh pose, and a climb was not ended: put the robot on a cell by hand");
  }
  const OffEdge way = PlanOffEdge(settings_, *pose, FreshWheels(robot_, now), upper_blocked_);
  if (!way.unclear.empty()) return Fail(way.unclear);
  // After a failure on level ground the robot stands; only a climb is not left as it is.
  const bool stands = steps_ == 0 && !before_.empty() && !way.on_edge && !board_.climbing.Get();
  if (!way.next || stands) return Done(way.to, now);
  to_upper_ = way.on_edge && way.next->drive &&
              settings_.grid.CellAt({way.next->drive->x_m, way.next->drive->y_m}) == way.to;
  if (++steps_ > kMostSteps) return Fail(way.text + ": it does not come off");
  if (steps_ == 1) robot_.Warn(way.text + ": goes to the centre of " + CellText(way.to));
  board_.active_action.Set("get_off_edge");
  board_.SetState(kActionRunning);
  Begin(*way.next, now);
  return Status::kRunning;
}

void GetOffEdge::Begin(const OffEdgeStep& step, Time now) {
  if (step.drive) {
    watch_.Begin(robot_.MoveToPose(kMoveServer, *step.drive),
                 {"off_edge_align", MoveClientName(kMoveServer), kMoveServer},
                 settings_.align_timeout_s, now);
    return;
  }
  const SuspensionGoal goal{static_cast<std::uint8_t>(SuspensionMode::kDirect), 0, step.wheels_mm,
                            settings_.suspension_timeout_s};
  watch_.Begin(robot_.ControlSuspension(kSuspensionServer, goal),
               {"SuspensionControl", "SuspensionControl", kSuspensionServer},
               settings_.suspension_timeout_s + kServerMarginS, now);
}

Status GetOffEdge::Done(const Cell& cell, Time now) {
  board_.climbing.Set(false);
  if (steps_ == 0) return Status::kSuccess;  // the place is known to the nodes that follow
  const std::optional<PoseFix> pose = FreshPose(robot_, settings_, now);
  board_.row.Set(cell.row);
  board_.col.Set(cell.col);
  board_.height_mm.Set(settings_.grid.HeightMm(cell));
  if (pose) board_.yaw_rad.Set(NormalizeYaw(pose->yaw_rad));
  board_.is_cell_center.Set(true);
  board_.suspension_offset_mm.Set(0);
  const std::string text = "it has gone to the centre of " + CellText(cell);
  message_.Set(text);
  board_.SetState(before_.empty() ? kActionSuccess : kActionFailed);
  if (!before_.empty()) board_.last_error.Set(before_ + "; " + text);
  return Status::kSuccess;
}

Status GetOffEdge::Fail(const std::string& why) {
  watch_.Cancel();
  board_.Fail(before_.empty() ? why : before_ + "; " + why);
  message_.Set(why);
  return Status::kFailure;
}

}  // namespace musher::meilin
