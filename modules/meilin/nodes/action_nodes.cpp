#include "musher/modules/meilin/nodes/action_nodes.hpp"

#include <utility>

#include <fmt/format.h>

#include "musher/modules/meilin/nodes/place.hpp"

namespace musher::meilin {

using tree::Status;

GoalNode::GoalNode(tree::Setup& setup, Robot& robot, std::string label, double limit_s,
                   const std::string& server)
    : label_(std::move(label)),
      timeout_s_(setup.Input<double>("timeout_sec", limit_s, "s; 0: no limit")),
      server_(setup.OptionalInput<std::string>("server_name", "of the action: " + server)),
      own_server_(server),
      robot_(robot),
      board_(setup.board()) {}

Status GoalNode::OnStart(const tree::Tick& tick) {
  board_.active_action.Set(label_);
  if (const std::string why = WhyNot(tick.now); !why.empty()) {
    board_.Fail(label_ + why);
    Report(label_ + why, 0);
    return Status::kFailure;
  }
  Begun begun = Begin();
  board_.SetState(kActionRunning);
  watch_.Begin(std::move(begun.goal), {label_, begun.client, server()}, limit_s(), tick.now);
  return Look(tick.now);
}

Status GoalNode::Look(Time now) {
  const Status status = watch_.Look(now);
  if (status == Status::kFailure) {
    board_.Fail(watch_.failure());
    Report(watch_.failure(), watch_.goal()->final_state());
    return Status::kFailure;
  }
  if (status == Status::kRunning && !IsEnough()) return Status::kRunning;
  board_.SetState(kActionSuccess);
  Report(watch_.goal()->message(), watch_.goal()->final_state());
  watch_.Release();
  return Status::kSuccess;
}

PoseNode::PoseNode(tree::Setup& setup, Robot& robot, const Settings& settings, const char* label)
    : GoalNode(setup, robot, label, 30, kMoveServer),
      x_m_(setup.Input<double>("target_x", "m, in the frame map")),
      y_m_(setup.Input<double>("target_y", "m, in the frame map")),
      yaw_rad_(setup.Input<double>("target_yaw", "rad")),
      max_speed_(setup.Input<double>("max_speed", 0.5, "m/s; not sent")),
      level_(setup.Input<bool>("level", true, "false: the way crosses heights, in a climb")),
      error_(setup.Output<std::string>("error_msg", "the failure, or \"\"")),
      settings_(settings) {}

std::string PoseNode::WhyNot(Time now) {
  const std::optional<PoseFix> pose = FreshPose(robot(), settings_, now);
  if (!level_.Get() || !pose) return "";  // without a pose its server does not drive
  const std::optional<RobotPlace> place = PlaceOf(*pose, settings_);
  const double height_mm = place ? place->height_mm : 0;
  const Point2 to{x_m_.Get(), y_m_.Get()};
  const auto other = settings_.grid.OtherHeightOnLine({pose->x_m, pose->y_m}, to, height_mm,
                                                      settings_.height_tolerance_mm);
  const bool over = !settings_.grid.CellAt(to) && height_mm > settings_.height_tolerance_mm;
  if (!other && !over) return "";
  return fmt::format(
      ": the straight way from x {:.2f} m, y {:.2f} m, {:g} mm high, to x {:.2f} m, y {:.2f} m "
      "{}",
      pose->x_m, pose->y_m, height_mm, to.x_m, to.y_m,
      other ? fmt::format("crosses {}, which has {} mm", CellText(*other),
                          settings_.grid.HeightMm(*other))
            : "leads off the field");
}

GoalNode::Begun PoseNode::Begin() {
  return {robot().MoveToPose(server(), {x_m_.Get(), y_m_.Get(), yaw_rad_.Get()}),
          MoveClientName(server())};
}

void PoseNode::Report(const std::string& message, int) {
  error_.Set(watch().succeeded() ? "" : message);
}

MoveToPose::MoveToPose(tree::Setup& setup, Robot& robot, const Settings& settings)
    : PoseNode(setup, robot, settings, "MoveToPose"),
      frame_id_(setup.OptionalInput<std::string>("frame_id", "of the target: map")) {
  const std::string* frame = frame_id_.entry() == nullptr ? frame_id_.Find() : nullptr;
  if (frame != nullptr && *frame != "map") {
    setup.Report("frame_id", Severity::kError,
                 "port 'frame_id': the server knows the frame map only; found '" + *frame + "'");
  }
}

SuspensionControl::SuspensionControl(tree::Setup& setup, Robot& robot)
    : GoalNode(setup, robot, "SuspensionControl", 30, kSuspensionServer),
      mode_(setup.Input<std::uint8_t>("mode", std::uint8_t{0}, "0 auto, 1 up, 2 down, 3 direct")),
      direction_(setup.Input<std::uint8_t>("direction", std::uint8_t{0},
                                           "0 forward, 1 left, 2 right, 3 backward")),
      height_mm_(setup.Input<double>("height", 0.0, "of the step, or of the wheels; mm")),
      message_(setup.Output<std::string>("message", "of the server, or the failure")),
      final_state_(setup.Output<int>("final_state", "of the sequence")) {}

GoalNode::Begun SuspensionControl::Begin() {
  const auto mode = static_cast<SuspensionMode>(mode_.Get());
  climbs_ = mode == SuspensionMode::kUp || mode == SuspensionMode::kDown;
  if (climbs_) board().climbing.Set(true);
  return {robot().ControlSuspension(server(),
                                    {mode_.Get(), direction_.Get(), height_mm_.Get(), limit_s()}),
          "SuspensionControl"};
}

// The robot stands between two platforms. What has ended the climb is not hidden.
void SuspensionControl::WhenHalted() {
  if (climbs_ && board().last_error.Get().empty()) {
    board().Fail("SuspensionControl was halted during a climb");
  }
}

void SuspensionControl::Report(const std::string& message, int final_state) {
  if (climbs_ && watch().succeeded()) board().climbing.Set(false);
  message_.Set(message);
  final_state_.Set(final_state);
}

ArmAction::ArmAction(tree::Setup& setup, Robot& robot)
    : GoalNode(setup, robot, "ArmAction", 30, kArmServer),
      command_(setup.Input<std::uint8_t>("command",
                                         "0 idle, 1 grasp, 2 store to body, 3 store on "
                                         "arm, 4 get body, 5 place mid, 6 place high")),
      wait_result_(setup.Input<bool>("wait_result", true, "false: done when it is accepted")),
      message_(setup.Output<std::string>("message", "of the server, or the failure")) {}

GoalNode::Begun ArmAction::Begin() {
  return {robot().MoveArm(server(), {command_.Get(), wait_result_.Get(), limit_s()}), "ArmAction"};
}

void ArmAction::Report(const std::string& message, int) {
  message_.Set(message);
}

SpearAction::SpearAction(tree::Setup& setup, Robot& robot)
    : GoalNode(setup, robot, "SpearAction", 5, kSpearServer),
      command_(setup.Input<std::uint8_t>(
          "command", "0 idle, 1 prepare, 2 grasp, 3 dock extend, 4 dock release")),
      message_(setup.Output<std::string>("message", "of the server, or the failure")) {}

GoalNode::Begun SpearAction::Begin() {
  if (command_.Get() == kSpearDock && board().dock_trues.Get() < 0) {
    board().dock_trues.Set(static_cast<int>(robot().partner_ready().trues));
  }
  return {robot().MoveSpear(server(), {command_.Get(), limit_s()}), "SpearAction"};
}

void SpearAction::Report(const std::string& message, int) {
  message_.Set(message);
}

}  // namespace musher::meilin
