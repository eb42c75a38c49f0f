#include "musher/modules/meilin/nodes/fetch.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace musher::meilin {
using tree::Status;

Fetch::Fetch(tree::Setup& setup, Robot& robot, const Settings& settings)
    : row_(setup.OptionalInput<int>("kfs_row", "row of the box")),
      col_(setup.OptionalInput<int>("kfs_col", "column of the box")),
      height_diff_mm_(
          setup.OptionalInput<double>("height_diff", "its cell's height - the robot's; mm")),
      yaw_rad_(setup.OptionalInput<double>("target_yaw", "heading towards the box, rad")),
      message_(setup.Output<std::string>("message", "\"Fetch done\", or the failure")),
      robot_(robot),
      settings_(settings),
      board_(setup.board()) {}

Status Fetch::OnStart(const tree::Tick& tick) {
  board_.active_action.Set("fetch");
  const int* row = row_.Find();
  const int* col = col_.Find();
  const double* yaw = yaw_rad_.Find();
  if (row == nullptr || col == nullptr || yaw == nullptr) {
    return Fail("Fetch missing kfs_row/kfs_col/target_yaw");
  }
  const Cell box{*row, *col};
  const double difference_mm = height_diff_mm_.Or(0.0);
  if (!std::isfinite(*yaw) || !std::isfinite(difference_mm)) {
    return Fail("Fetch target_yaw and height_diff must be finite");
  }
  const Start start = Locate(robot_, board_, settings_, tick.now, "Fetch");
  if (!start.why.empty()) return Fail(start.why);
  const Cell here = start.place.cell;
  if (const std::string why = CheckedElsewhere(board_, here, "Fetch"); !why.empty()) {
    return Fail(why);
  }
  if (!IsInside(box) || !AreNeighbours(here, box)) {
    return Fail("Fetch KFS grid " + CellText(box) + " must be adjacent to current grid " +
                CellText(here));
  }
  const bool lifts = std::abs(difference_mm) > settings_.height_tolerance_mm;
  const double height_mm = settings_.normal_height_mm + difference_mm;
  if (lifts && height_mm < 0) {
    return Fail(fmt::format("Fetch suspension height is negative: {:g} mm + height_diff {:g} mm",
                            settings_.normal_height_mm, difference_mm));
  }
  box_ = box;
  board_.row.Set(here.row);
  board_.col.Set(here.col);
  board_.height_mm.Set(start.place.height_mm);
  to_yaw_rad_ = NormalizeYaw(*yaw);
  lift_mm_ = lifts ? difference_mm : 0;
  board_.SetState(kActionRunning);
  const Pose2 grasp = settings_.grid.GraspPose(here, box, to_yaw_rad_);
  board_.is_cell_center.Set(false);  // from now on, also if it fails
  align_.Begin(robot_.MoveToPose(kMoveServer, {grasp.x_m, grasp.y_m, grasp.yaw_rad}),
               {"grasp_align", MoveClientName(kMoveServer), kMoveServer}, settings_.align_timeout_s,
               tick.now);
  if (lifts) {
    const SuspensionGoal lift{static_cast<std::uint8_t>(SuspensionMode::kDirect), 0, height_mm,
                              settings_.suspension_timeout_s};
    suspension_.Begin(robot_.ControlSuspension(kSuspensionServer, lift),
                      {"SuspensionControl", "SuspensionControl", kSuspensionServer},
                      settings_.suspension_timeout_s + kServerMarginS, tick.now);
  }
  return Look(tick.now);
}

Status Fetch::Look(Time now) {
  if (arm_.goal() == nullptr) return LookAtReach(now);
  const Status arm = arm_.Look(now);
  if (arm == Status::kFailure) return Fail(arm_.failure());
  return arm == Status::kSuccess ? Done() : Status::kRunning;
}

Status Fetch::LookAtReach(Time now) {
  const Status align = align_.Look(now);
  const Status suspension = suspension_.Look(now);
  // The wheels are lifted from here on, whatever comes.
  if (suspension == Status::kSuccess) board_.suspension_offset_mm.Set(lift_mm_);
  if (suspension == Status::kFailure) return Fail(suspension_.failure());
  if (align == Status::kFailure) return Fail(align_.failure());
  if (align == Status::kRunning || suspension == Status::kRunning) return Status::kRunning;
  board_.yaw_rad.Set(to_yaw_rad_);
  arm_.Begin(robot_.MoveArm(kArmServer, {kArmGrasp, true, settings_.grasp_timeout_s}),
             {"ArmAction", "ArmAction", kArmServer}, settings_.grasp_timeout_s, now);
  return Status::kRunning;
}

Status Fetch::Done() {
  board_.Take(box_);
  align_.Release();
  suspension_.Release();
  arm_.Release();
  board_.SetState(kActionSuccess);
  message_.Set("Fetch done");
  return Status::kSuccess;
}

Status Fetch::Fail(const std::string& why) {
  CancelAll();
  board_.Fail(why);
  message_.Set(why);
  return Status::kFailure;
}

void Fetch::CancelAll() {
  for (GoalWatch* watch : {&align_, &suspension_, &arm_}) {
    watch->Cancel();
    watch->Release();
  }
}

}  // namespace musher::meilin
