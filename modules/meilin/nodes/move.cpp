#include "musher/modules/meilin/nodes/move.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "musher/modules/meilin/nodes/edge.hpp"

namespace musher::meilin {
namespace {

MoveGoal ToGoal(const Pose2& pose) {
  return {pose.x_m, pose.y_m, pose.yaw_rad};
}

GoalWatch::Names AlignNames(const char* what) {
  return {what, MoveClientName(kMoveServer), kMoveServer};
}

}  // namespace

using tree::Status;

Move::Move(tree::Setup& setup, Robot& robot, const Settings& settings)
    : row_(setup.OptionalInput<int>("move_row", "row of the target cell")),
      col_(setup.OptionalInput<int>("move_col", "column of the target cell")),
      height_mm_(setup.OptionalInput<double>("target_height_mm", "of its platform; missing: 0")),
      yaw_rad_(setup.OptionalInput<double>("target_yaw", "heading at the target, rad")),
      message_(setup.Output<std::string>("message", "\"Move done\", or the failure")),
      robot_(robot),
      settings_(settings),
      board_(setup.board()) {}

Status Move::OnStart(const tree::Tick& tick) {
  board_.active_action.Set("move");
  if (const std::string why = MakePlan(tick.now); !why.empty()) return Fail(why);
  board_.SetState(kActionRunning);
  preparing_ = plan_.pre_align || plan_.lowers;
  if (preparing_) {
    Prepare(tick.now);
  } else {
    Travel(tick.now);
  }
  return Look(tick.now);
}

Status Move::OnRunning(const tree::Tick& tick) {
  return Look(tick.now);
}

std::string Move::MakePlan(Time now) {
  const int* row = row_.Find();
  const int* col = col_.Find();
  const double* yaw = yaw_rad_.Find();
  if (row == nullptr || col == nullptr || yaw == nullptr) {
    return "Move missing move_row/move_col/target_yaw";
  }
  plan_ = {};
  plan_.to = {*row, *col};
  plan_.to_yaw_rad = NormalizeYaw(*yaw);
  plan_.to_height_mm = height_mm_.Or(0.0);
  if (!IsInside(plan_.to)) return "Move target " + CellText(plan_.to) + " is outside Meilin grid";
  if (!std::isfinite(*yaw) || !std::isfinite(plan_.to_height_mm)) {
    return "Move target_yaw and target_height_mm must be finite";
  }
  const Start start = Locate(robot_, board_, settings_, now, "Move");
  if (!start.why.empty()) return start.why;
  plan_.from = start.place;
  if (std::string why = PlanClimb(); !why.empty()) return why;
  if (!plan_.climb) {
    if (std::string why = CheckFlat(now); !why.empty()) return why;
  }
  const std::optional<Wheels> wheels = FreshWheels(robot_, now);
  const bool out =
      wheels ? LongestMm(*wheels) > settings_.normal_height_mm + kLongWheelMm
             : std::abs(board_.suspension_offset_mm.Get()) > settings_.height_tolerance_mm;
  const bool up = plan_.climb && plan_.to_height_mm > plan_.from.height_mm;
  plan_.lowers = out && !up;
  const bool turns = plan_.climb && YawDistance(plan_.from.yaw_rad, plan_.to_yaw_rad) >
                                        settings_.yaw_tolerance_rad;
  if (!plan_.from.is_center || turns) {
    const double yaw_rad = plan_.climb ? plan_.to_yaw_rad : plan_.from.yaw_rad;
    plan_.pre_align = ToGoal(settings_.grid.CentrePose(plan_.from.cell, yaw_rad));
  }
  return "";
}

std::string Move::CheckFlat(Time now) const {
  const std::optional<PoseFix> pose = FreshPose(robot_, settings_, now);
  const Point2 centre = settings_.grid.Centre(plan_.from.cell);
  // From off the centre it goes back there first.
  const Point2 from = pose && plan_.from.is_center ? Point2{pose->x_m, pose->y_m} : centre;
  const auto other = settings_.grid.OtherHeightOnLine(
      from, settings_.grid.Centre(plan_.to), plan_.from.height_mm, settings_.height_tolerance_mm);
  if (!other) return "";
  return fmt::format("Move from {} to {} crosses {}, which has {} mm", CellText(plan_.from.cell),
                     CellText(plan_.to), CellText(*other), settings_.grid.HeightMm(*other));
}

std::string Move::PlanClimb() {
  const double difference_mm = plan_.to_height_mm - plan_.from.height_mm;
  if (std::abs(difference_mm) <= settings_.height_tolerance_mm) return "";
  if (std::string why = CheckedElsewhere(board_, plan_.from.cell, "Move"); !why.empty()) {
    return why;
  }
  const std::optional<Direction> way = DirectionTo(plan_.from.cell, plan_.to);
  if (!way) {
    return "Move climb direction is invalid: " + CellText(plan_.from.cell) + " and " +
           CellText(plan_.to) + " are no neighbours, and differ in height";
  }
  const double turned_rad = YawOf(*way) - plan_.to_yaw_rad;
  const Direction direction = NearestDirection(NormalizeYaw(turned_rad));
  if (YawDistance(turned_rad, YawOf(direction)) > settings_.yaw_tolerance_rad) {
    return fmt::format(
        "Move climb direction is invalid: target_yaw {:.2f} rad is across the path "
        "{}; expected a right angle within {:.2f} rad",
        plan_.to_yaw_rad, DirectionText(*way), settings_.yaw_tolerance_rad);
  }
  const SuspensionMode mode = difference_mm > 0 ? SuspensionMode::kUp : SuspensionMode::kDown;
  plan_.climb =
      SuspensionGoal{static_cast<std::uint8_t>(mode), static_cast<std::uint8_t>(CodeOf(direction)),
                     std::abs(difference_mm), settings_.suspension_timeout_s};
  return "";
}

void Move::Prepare(Time now) {
  if (plan_.pre_align) {
    align_.Begin(robot_.MoveToPose(kMoveServer, *plan_.pre_align), AlignNames("pre_align"),
                 settings_.align_timeout_s, now);
  }
  if (plan_.lowers) {
    const SuspensionGoal lower{static_cast<std::uint8_t>(SuspensionMode::kDirect), 0,
                               settings_.normal_height_mm, settings_.suspension_timeout_s};
    suspension_.Begin(robot_.ControlSuspension(kSuspensionServer, lower),
                      {"SuspensionControl", "SuspensionControl", kSuspensionServer},
                      settings_.suspension_timeout_s + kServerMarginS, now);
  }
}

void Move::Travel(Time now) {
  preparing_ = false;
  align_.Cancel();
  suspension_.Cancel();
  const Pose2 target = settings_.grid.CentrePose(plan_.to, plan_.to_yaw_rad);
  align_.Begin(robot_.MoveToPose(kMoveServer, ToGoal(target)), AlignNames("target_align"),
               settings_.align_timeout_s, now);
  if (plan_.climb) {
    board_.climbing.Set(true);
    suspension_.Begin(robot_.ControlSuspension(kSuspensionServer, *plan_.climb),
                      {"SuspensionControl", "SuspensionControl", kSuspensionServer},
                      settings_.suspension_timeout_s + kServerMarginS, now);
  }
}

Status Move::Look(Time now) {
  const Status align = align_.Look(now);
  const Status suspension = suspension_.Look(now);
  if (suspension == Status::kFailure) return Fail(suspension_.failure());
  if (align == Status::kFailure) return Fail(align_.failure());
  if (preparing() && plan_.lowers && suspension == Status::kSuccess) {
    board_.suspension_offset_mm.Set(0);
  }
  if (align == Status::kRunning || suspension == Status::kRunning) return Status::kRunning;
  if (!preparing()) return Done(now);
  Travel(now);
  return Status::kRunning;
}

Status Move::Done(Time now) {
  align_.Release();
  suspension_.Release();
  if (const std::string wrong = WrongBody(robot_, settings_, now, plan_.to_height_mm);
      !wrong.empty()) {
    return Fail("Move has come to " + CellText(plan_.to) + ", but " + wrong);
  }
  board_.climbing.Set(false);
  board_.row.Set(plan_.to.row);
  board_.col.Set(plan_.to.col);
  board_.height_mm.Set(plan_.to_height_mm);
  board_.yaw_rad.Set(plan_.to_yaw_rad);
  board_.is_cell_center.Set(true);
  board_.suspension_offset_mm.Set(0);
  board_.SetState(kActionSuccess);
  message_.Set("Move done");
  return Status::kSuccess;
}

Status Move::Fail(const std::string& why) {
  align_.Cancel();
  suspension_.Cancel();
  board_.Fail(why);
  message_.Set(why);
  return Status::kFailure;
}

void Move::OnHalted(const tree::Tick&) {
  const bool climbs = !preparing() && plan_.climb && suspension_.running();
  align_.Cancel();
  suspension_.Cancel();
  if (!climbs) return;
  board_.Fail("Move was halted during a climb from " + CellText(plan_.from.cell) + " to " +
              CellText(plan_.to));
}

}  // namespace musher::meilin
